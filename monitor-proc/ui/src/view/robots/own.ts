// Robots without a dress of ours: the primitives of their own URDF, or, where
// it has none, capsules between the joints.
import type { URDFJoint, URDFLink } from "urdf-loader";
import type { Vec3 } from "../../net/protocol";
import { PAINT } from "../materials";
import { box, capsule, cylinder, sphere, taper } from "../shapes";
import { type Part, part } from "./part";

const { silver } = PAINT;

function numbers(text: string | null | undefined): Vec3 {
  const [x = 0, y = 0, z = 0] = (text ?? "").trim().split(/\s+/).map(Number);
  return [x || 0, y || 0, z || 0];
}

function child(element: Element | undefined, name: string): Element | undefined {
  return [...(element?.children ?? [])].find((node) => node.nodeName.toLowerCase() === name);
}

/** The primitive in a `<visual>` or `<collision>`, or null for a mesh. */
function primitive(element: Element): Part | null {
  const shape = child(element, "geometry")?.children[0];
  if (shape === undefined) return null;
  const size = (name: string) => Number(shape.getAttribute(name)) || 0.01;
  const origin = child(element, "origin");
  const at = numbers(origin?.getAttribute("xyz"));
  const turn = numbers(origin?.getAttribute("rpy"));
  switch (shape.nodeName.toLowerCase()) {
    case "box":
      return part(box(...numbers(shape.getAttribute("size")), 0.006), silver, at, turn);
    case "sphere":
      return part(sphere(size("radius")), silver, at, turn);
    case "cylinder":
      return part(cylinder(size("radius"), size("length"), 0.006), silver, at, turn);
    case "capsule":
      return part(capsule(size("radius"), size("length")), silver, at, turn);
    default:
      return null;
  }
}

function primitives(link: URDFLink, kind: string): Part[] {
  const elements = [...(link.urdfNode?.children ?? [])].filter((node) => node.nodeName.toLowerCase() === kind);
  return elements.map(primitive).filter((found) => found !== null);
}

/** A rod from the link's frame to each joint that it carries. */
function rods(link: URDFLink): Part[] {
  const joints = link.children.filter((object): object is URDFJoint => "isURDFJoint" in object);
  return joints
    .filter((joint) => joint.position.length() > 0.02)
    .map((joint) => part(taper([0, 0, 0], joint.position.toArray() as Vec3, 0.03, 0.027), silver));
}

function shapesOf(link: URDFLink): Part[] {
  const visual = primitives(link, "visual");
  return visual.length > 0 ? visual : primitives(link, "collision");
}

/** Whether any of `links` has a shape: then a link without one is a mere frame. */
export function hasShapes(links: URDFLink[]): boolean {
  return links.some((link) => shapesOf(link).length > 0);
}

/** What can be drawn of `link` from the URDF alone; `shaped` as `hasShapes` says. */
export function ownParts(link: URDFLink, shaped: boolean): Part[] {
  return shaped ? shapesOf(link) : rods(link);
}
