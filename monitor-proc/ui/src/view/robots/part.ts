// A robot's dress is a list of parts per link, merged per paint.
import { type BufferGeometry, Euler, Matrix4, Mesh, type Object3D, Quaternion, Vector3 } from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import type { Vec3 } from "../../net/protocol";
import { hasTwin, ofDetail } from "../detail";
import { type Look, material } from "../materials";
import { coarsely } from "../shapes";

/** One primitive in the frame of its link; the turn is roll, pitch, yaw (rad). */
export interface Part {
  geometry: BufferGeometry;
  look: Look;
}

/** The parts of each link, by the link's name. */
export type Dress = Record<string, () => Part[]>;

export const QUARTER = Math.PI / 2;

/** A part at `position`, turned about x, then y, then z. */
export function part(geometry: BufferGeometry, look: Look, position: Vec3 = [0, 0, 0], turn: Vec3 = [0, 0, 0]): Part {
  geometry.applyMatrix4(
    new Matrix4().compose(
      new Vector3(...position),
      new Quaternion().setFromEuler(new Euler(turn[0], turn[1], turn[2], "ZYX")),
      new Vector3(1, 1, 1),
    ),
  );
  return { geometry, look };
}

interface Merged {
  geometry: BufferGeometry;
  look: Look;
}

function merge(parts: Part[]): Merged[] {
  const byLook = new Map<Look, BufferGeometry[]>();
  for (const { geometry, look } of parts) {
    const same = byLook.get(look) ?? [];
    same.push(geometry);
    byLook.set(look, same);
  }
  return [...byLook].map(([look, geometries]) => ({ geometry: mergeGeometries(geometries), look }));
}

/** Two arms of one kind share their geometries. */
const merged = new Map<string, Merged[]>();

/** Meshes of what `parts` makes again; those of the same `key` share their geometries. */
export function meshes(key: string, parts: () => Part[]): Object3D[] {
  let all = merged.get(key);
  if (all === undefined) {
    all = merge(parts());
    all.forEach(({ geometry }, index) => {
      hasTwin(geometry, () => merge(coarsely(parts))[index]?.geometry ?? geometry);
    });
    merged.set(key, all);
  }
  return all.map(({ geometry, look }) => {
    const mesh = new Mesh(ofDetail(geometry), material(look));
    mesh.castShadow = true;
    mesh.receiveShadow = true;
    return mesh;
  });
}
