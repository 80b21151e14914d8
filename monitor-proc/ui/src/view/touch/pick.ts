// What lies under the pointer.
import { Raycaster, Vector2, Vector3, type PerspectiveCamera, type Ray } from "three";
import type { Cell, Owner } from "../cell";

/** What was hit, and the point of it (m). */
export interface Hit extends Owner {
  point: Vector3;
}

const caster = new Raycaster();

/** The ray through a point of `element`, from an event's client coordinates. */
export function rayAt(
  x: number,
  y: number,
  element: HTMLElement,
  camera: PerspectiveCamera,
): Ray {
  const frame = element.getBoundingClientRect();
  const across = (2 * (x - frame.left)) / frame.width - 1;
  const up = 1 - (2 * (y - frame.top)) / frame.height;
  camera.updateMatrixWorld();
  caster.setFromCamera(new Vector2(across, up), camera);
  return caster.ray;
}

/**
 * What the last ray of `rayAt` meets first; furniture hides what is behind it,
 * and so do arms unless the hand reaches `throughArms`.
 */
export function pick(cell: Cell, throughArms = false): Hit | null {
  for (const { object, point } of caster.intersectObject(cell.root, true)) {
    if (!isShown(object)) continue;
    const owner = cell.ownerOf(object);
    if (throughArms && owner.arm !== null) continue;
    return { ...owner, point: point.clone() };
  }
  return null;
}

function isShown(object: { visible: boolean; parent: unknown } | null): boolean {
  for (let at = object; at !== null; at = at.parent as typeof at) {
    if (!at.visible) return false;
  }
  return true;
}
