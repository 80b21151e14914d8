// What lies under the pointer.
import { Raycaster, Vector2, Vector3, type PerspectiveCamera, type Ray } from "three";
import type { Body, Cell } from "../cell";

/** A body or an arm, and the point of it that was hit (m). */
export interface Hit {
  body: Body | null;
  arm: number | null;
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
    const { body, arm } = cell.ownerOf(object);
    if (throughArms && arm !== null) continue;
    return { body, arm, point: point.clone() };
  }
  return null;
}

function isShown(object: { visible: boolean; parent: unknown } | null): boolean {
  for (let at = object; at !== null; at = at.parent as typeof at) {
    if (!at.visible) return false;
  }
  return true;
}
