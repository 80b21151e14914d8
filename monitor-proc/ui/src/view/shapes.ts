// Geometries of the built-in look. All are indexed and carry positions and
// normals only, so that the parts of a link can be merged into one draw call.
import {
  BoxGeometry,
  type BufferGeometry,
  LatheGeometry,
  Quaternion,
  SphereGeometry,
  TorusGeometry,
  Vector2,
  Vector3,
} from "three";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import { mergeGeometries, mergeVertices } from "three/addons/utils/BufferGeometryUtils.js";
import type { Vec3 } from "../net/protocol";

interface Facets {
  round: number;
  cap: number;
  bevel: number;
  /** Of the edges of a box; 0 for sharp ones. */
  edge: number;
}

const FINE: Facets = { round: 22, cap: 4, bevel: 3, edge: 2 };
const COARSE: Facets = { round: 11, cap: 2, bevel: 1, edge: 0 };
const QUARTER = Math.PI / 2;

let facets = FINE;

/** What `make` makes, with few facets. */
export function coarsely<T>(make: () => T): T {
  facets = COARSE;
  try {
    return make();
  } finally {
    facets = FINE;
  }
}

function plain(geometry: BufferGeometry): BufferGeometry {
  geometry.deleteAttribute("uv");
  return geometry.index === null ? mergeVertices(geometry) : geometry;
}

/** A profile of (radius, height), turned around z. */
function turned(profile: Vector2[], segments = facets.round): BufferGeometry {
  const geometry = new LatheGeometry(profile, segments);
  geometry.rotateX(QUARTER);
  return plain(geometry);
}

/** An arc of the profile around (`radius`, `height`), from angle `from` to `to`. */
function arc(radius: number, height: number, r: number, from: number, to: number, steps: number) {
  return Array.from({ length: steps + 1 }, (_, step) => {
    const angle = from + ((to - from) * step) / steps;
    return new Vector2(Math.max(0, radius + r * Math.cos(angle)), height + r * Math.sin(angle));
  });
}

/** A cylinder along z with its middle at the origin and rounded rims (m). */
export function cylinder(
  bottom: number,
  height: number,
  bevel = 0.004,
  top = bottom,
  segments = facets.round,
): BufferGeometry {
  const rim = Math.min(bevel, height / 2, bottom, top);
  const half = height / 2;
  return turned(
    [
      new Vector2(0, -half),
      ...arc(bottom - rim, rim - half, rim, -QUARTER, 0, facets.bevel),
      ...arc(top - rim, half - rim, rim, 0, QUARTER, facets.bevel),
      new Vector2(0, half),
    ],
    segments,
  );
}

/** A capsule from `a` to `b` with the radii `ra` and `rb` there (m). */
export function taper(a: Vec3, b: Vec3, ra: number, rb: number): BufferGeometry {
  const from = new Vector3(...a);
  const along = new Vector3(...b).sub(from);
  const length = along.length();
  const geometry = turned([...arc(0, 0, ra, -QUARTER, 0, facets.cap), ...arc(0, length, rb, 0, QUARTER, facets.cap)]);
  const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), along.normalize());
  geometry.applyQuaternion(turn);
  geometry.translate(...a);
  return geometry;
}

/** A capsule along z with its middle at the origin; `length` without the caps (m). */
export function capsule(radius: number, length: number): BufferGeometry {
  return taper([0, 0, -length / 2], [0, 0, length / 2], radius, radius);
}

/** A box with round edges, or with sharp ones where `edge` is 0 (m). */
export function box(x: number, y: number, z: number, edge = 0.004): BufferGeometry {
  if (edge === 0 || facets.edge === 0) return plain(new BoxGeometry(x, y, z));
  const radius = Math.min(edge, x / 2.01, y / 2.01, z / 2.01);
  return plain(new RoundedBoxGeometry(x, y, z, facets.edge, radius));
}

/** How far the ribs and the rim of a bin stand out (m): they are only drawn. */
export const RIB_M = 0.0025;
const RIB_PITCH_M = 0.05;

/** An open bin with ribs and a rim; outer sides and thickness of its walls (m). */
export function bin(x: number, y: number, z: number, wall: number): BufferGeometry {
  const parts: BufferGeometry[] = [];
  const add = (size: Vec3, at: Vec3) => parts.push(plain(new BoxGeometry(...size)).translate(...at));
  add([x, y, wall], [0, 0, (wall - z) / 2]);
  const rim = Math.min(0.008, z / 4);
  for (const side of [-1, 1]) {
    add([wall, y, z - wall], [(side * (x - wall)) / 2, 0, wall / 2]);
    add([x - 2 * wall, wall, z - wall], [0, (side * (y - wall)) / 2, wall / 2]);
    if (facets !== FINE) continue;
    add([x + 2 * RIB_M, RIB_M, rim], [0, (side * (y + RIB_M)) / 2, (z - rim) / 2]);
    add([RIB_M, y, rim], [(side * (x + RIB_M)) / 2, 0, (z - rim) / 2]);
    for (const at of ribs(x)) add([2 * RIB_M, RIB_M, z - rim], [at, (side * (y + RIB_M)) / 2, -rim / 2]);
    for (const at of ribs(y)) add([RIB_M, 2 * RIB_M, z - rim], [(side * (x + RIB_M)) / 2, at, -rim / 2]);
  }
  return mergeGeometries(parts);
}

/** Where the ribs of a wall stand (m from its middle). */
function ribs(length: number): number[] {
  const count = Math.max(2, Math.round(length / RIB_PITCH_M));
  const first = RIB_M - length / 2;
  return Array.from({ length: count }, (_, index) => first + (index * (length - 2 * RIB_M)) / (count - 1));
}

export function sphere(radius: number, segments = facets.round): BufferGeometry {
  const geometry = new SphereGeometry(radius, segments, Math.ceil(segments / 2));
  geometry.rotateX(QUARTER);
  return plain(geometry);
}

/** A ring around z (m). */
export function ring(radius: number, thickness: number): BufferGeometry {
  return plain(new TorusGeometry(radius, thickness, facets === FINE ? 6 : 3, 2 * facets.round));
}
