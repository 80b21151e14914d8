// Geometries and their coarse twins: fewer facets, for where a program draws and
// every triangle costs.
import { type BufferGeometry, Mesh, type Object3D } from "three";

interface Pair {
  fine: BufferGeometry;
  coarse: BufferGeometry | null;
  make: () => BufferGeometry;
}

const pairs = new WeakMap<BufferGeometry, Pair>();
let coarse = false;

function now(pair: Pair): BufferGeometry {
  if (!coarse) return pair.fine;
  if (pair.coarse === null) {
    pair.coarse = pair.make();
    pairs.set(pair.coarse, pair);
  }
  return pair.coarse;
}

/** Says how the coarse twin of `fine` is made; it is made when it is needed. */
export function hasTwin(fine: BufferGeometry, make: () => BufferGeometry): void {
  pairs.set(fine, { fine, coarse: null, make });
}

/** `geometry`, or its twin: whichever is in use now. */
export function ofDetail(geometry: BufferGeometry): BufferGeometry {
  const pair = pairs.get(geometry);
  return pair === undefined ? geometry : now(pair);
}

/** Shows `fine`, or the `plain` ones in its place: whichever is in use now. */
export function eitherOr(fine: Object3D, plain: Object3D[]): void {
  fine.userData.coarse = false;
  for (const object of plain) object.userData.coarse = true;
  for (const object of [fine, ...plain]) choose(object);
}

function choose(object: Object3D): void {
  const wanted: unknown = object.userData.coarse;
  if (typeof wanted === "boolean") object.visible = wanted === coarse;
}

/** Uses the coarse twins, or the fine ones, for all meshes under `root`. */
export function useCoarse(on: boolean, root: Object3D): void {
  if (on === coarse) return;
  coarse = on;
  root.traverse((object) => {
    if (object instanceof Mesh) object.geometry = ofDetail(object.geometry as BufferGeometry);
    choose(object);
  });
}
