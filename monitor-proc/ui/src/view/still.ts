// Objects that do not move in their parent: three.js would compute their matrices for each picture.
import type { Object3D } from "three";

/** Keeps the places of `root` and of all below it. */
export function still<T extends Object3D>(root: T): T {
  root.traverse((object) => {
    object.updateMatrix();
    object.matrixAutoUpdate = false;
  });
  return root;
}
