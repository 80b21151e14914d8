// Three arrows: x red, y green, z blue.
import {
  BufferGeometry,
  ConeGeometry,
  CylinderGeometry,
  Float32BufferAttribute,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
} from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import { plainPaint } from "./overlay";

const AXES = [
  { colour: [0.93, 0.24, 0.2], turn: [0, 0, -Math.PI / 2] },
  { colour: [0.27, 0.78, 0.27], turn: [0, 0, 0] },
  { colour: [0.24, 0.5, 1], turn: [Math.PI / 2, 0, 0] },
] as const;
const SEGMENTS = 10;

/** A frame with arrows of `length`, drawn over all else where `over` is set (m). */
export function triad(length: number, thickness: number, over: boolean, opacity = 1): Mesh {
  const parts = AXES.flatMap(({ colour, turn }) => {
    const shaft = new CylinderGeometry(thickness, thickness, length * 0.8, SEGMENTS);
    shaft.translate(0, length * 0.4, 0);
    const tip = new ConeGeometry(2.4 * thickness, length * 0.2, SEGMENTS);
    tip.translate(0, length * 0.9, 0);
    return [shaft, tip].map((geometry) => {
      geometry.rotateX(turn[0]).rotateY(turn[1]).rotateZ(turn[2]);
      const count = geometry.getAttribute("position").count;
      const colours = Array.from({ length: count }, () => colour).flat();
      geometry.setAttribute("color", new Float32BufferAttribute(colours, 3));
      return geometry;
    });
  });
  const paint = { ...plainPaint(over), vertexColors: true, transparent: over || opacity < 1, opacity };
  const mesh = new Mesh(mergeGeometries(parts), new MeshBasicMaterial(paint));
  // A line is not thinner than a pixel, whatever the resolution.
  const lines = new LineSegments(axisLines(length), new LineBasicMaterial(paint));
  for (const part of [mesh, lines]) {
    part.renderOrder = over ? 10 : 0;
    part.raycast = () => {};
  }
  mesh.add(lines);
  return mesh;
}

/** A line along each axis. */
function axisLines(length: number): BufferGeometry {
  const ends = [0, 1, 2].flatMap((axis) => [0, 0, 0, ...[0, 1, 2].map((one) => (one === axis ? length : 0))]);
  const colours = AXES.flatMap(({ colour }) => [...colour, ...colour]);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(ends, 3));
  geometry.setAttribute("color", new Float32BufferAttribute(colours, 3));
  return geometry;
}
