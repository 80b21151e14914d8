// Meshes of the cell's objects and fixtures.
import { BackSide, type BufferGeometry, Color, Group, Mesh, MeshBasicMaterial } from "three";
import type { Pose, Shape, Vec3 } from "../net/protocol";
import { hasTwin, ofDetail } from "./detail";
import { type Look, material } from "./materials";
import { bin, box, capsule, coarsely, cylinder, RIB_M, sphere } from "./shapes";

const EDGE_M = 0.004;
const OUTLINE_M = 0.0035;
/** Half the height of the largest part that is poured (m). */
const PART_M = 0.024;

const geometries = new Map<string, BufferGeometry>();

/** Bodies of the same shape share their geometry; `grown` adds a margin (m). */
function geometry(shape: Exclude<Shape, { kind: "compound" }>, grown: number): BufferGeometry {
  const key = `${JSON.stringify(shape)} ${grown}`;
  let made = geometries.get(key);
  if (made === undefined) {
    made = build(shape, grown);
    hasTwin(made, () => coarsely(() => build(shape, grown)));
    geometries.set(key, made);
  }
  return ofDetail(made);
}

function build(shape: Exclude<Shape, { kind: "compound" }>, grown: number): BufferGeometry {
  switch (shape.kind) {
    case "box": {
      const [x, y, z] = shape.size_m.map((side) => side + 2 * grown) as Vec3;
      return box(x, y, z, EDGE_M + grown);
    }
    case "sphere":
      return sphere(shape.radius_m + grown);
    case "cylinder":
      return cylinder(shape.radius_m + grown, shape.length_m + 2 * grown, EDGE_M + grown);
    case "capsule":
      return capsule(shape.radius_m + grown, shape.length_m);
    case "bin": {
      const [x, y, z] = shape.size_m.map((side) => side + 2 * grown) as Vec3;
      // A rim stays outside: walls that are grown would fill the inside.
      if (grown > 0) return box(x + 2 * RIB_M, y + 2 * RIB_M, z, EDGE_M);
      return bin(x, y, z, shape.wall_m);
    }
  }
}

/** Puts `object` where `pose` says. */
export function place(object: Group | Mesh, pose: Pose): void {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
}

function fill(group: Group, shape: Shape, make: (geometry: BufferGeometry) => Mesh, grown: number) {
  if (shape.kind !== "compound") {
    group.add(make(geometry(shape, grown)));
    return;
  }
  for (const { shape: inner, pose } of shape.parts) {
    const holder = new Group();
    fill(holder, inner, make, grown);
    place(holder, pose);
    group.add(holder);
  }
}

/** A colour of the scene. */
export function srgb([red, green, blue]: Vec3): Color {
  return new Color().setRGB(red, green, blue, "srgb");
}

/** Loose parts are of polished metal. */
function gloss(shape: Shape): Partial<Look> {
  return halfHeight(shape) < PART_M && shape.kind !== "bin" ? { roughness: 0.26, metalness: 0.35 } : {};
}

/** The body of `shape`, lit and with a shadow. */
export function body(name: string, shape: Shape, colour: Vec3, look: Partial<Look> = {}): Group {
  const group = new Group();
  group.name = name;
  const paint = material({ colour: srgb(colour), roughness: 0.42, ...gloss(shape), ...look });
  const make = (form: BufferGeometry) => {
    const mesh = new Mesh(form, paint);
    mesh.castShadow = true;
    mesh.receiveShadow = true;
    return mesh;
  };
  fill(group, shape, make, 0);
  return group;
}

const outlines = new Map<number, MeshBasicMaterial>();

/** A rim of `colour` around a body of `shape`: its back faces, grown by `rim_m`. */
export function outline(shape: Shape, colour: number, rim_m = OUTLINE_M): Group {
  let paint = outlines.get(colour);
  if (paint === undefined) {
    paint = new MeshBasicMaterial({ color: colour, side: BackSide, toneMapped: false });
    outlines.set(colour, paint);
  }
  const skin = paint;
  const group = new Group();
  fill(group, shape, (form) => new Mesh(form, skin), rim_m);
  // A rim must not be grabbed in the place of a body.
  group.traverse((object) => {
    object.raycast = () => {};
  });
  return group;
}

/** Half the height of an upright shape (m). */
export function halfHeight(shape: Shape): number {
  switch (shape.kind) {
    case "box":
    case "bin":
      return shape.size_m[2] / 2;
    case "sphere":
      return shape.radius_m;
    case "cylinder":
      return shape.length_m / 2;
    case "capsule":
      return shape.length_m / 2 + shape.radius_m;
    case "compound":
      return Math.max(...shape.parts.map(({ shape: inner, pose }) => Math.abs(pose[2]) + halfHeight(inner)), 0);
  }
}
