// The body under the pointer.
import { type Ray, Vector2, type Vector3 } from "three";
import type { Cell, Owner } from "../cell";
import type { Lens } from "../lens";
import { bodyCaster } from "./layers";

/** What was hit, and the point of it (m). */
export interface Hit extends Owner {
  point: Vector3;
}

const caster = bodyCaster();
/** So far beside a body a press still means it (pixels). */
const NEAR_PX = 12;
const DIRECTIONS = 8;

/** The ray through a point of `element`, from an event's client coordinates. */
export function rayAt(x: number, y: number, element: HTMLElement, lens: Lens): Ray {
  const frame = element.getBoundingClientRect();
  const across = (2 * (x - frame.left)) / frame.width - 1;
  const up = 1 - (2 * (y - frame.top)) / frame.height;
  lens.updateMatrixWorld();
  caster.setFromCamera(new Vector2(across, up), lens);
  return caster.ray;
}

/**
 * The first body that the last ray of `rayAt` meets; furniture hides bodies behind
 * it, and so do arms unless `throughArms`.
 */
export function pick(cell: Cell, throughArms = false): Hit | null {
  const among = throughArms ? cell.withoutArms() : [cell.root];
  for (const { object, point } of caster.intersectObjects(among, true)) {
    if (!isShown(object)) continue;
    return { ...cell.ownerOf(object), point: point.clone() };
  }
  return null;
}

/**
 * The body at a point of `element`, or beside it by at most `NEAR_PX`. A body that a gripper
 * holds, or hides, counts as well.
 */
export function bodyNear(x: number, y: number, element: HTMLElement, lens: Lens, cell: Cell): Hit | null {
  const around = [0, NEAR_PX / 2, NEAR_PX].flatMap((radius) =>
    Array.from({ length: radius === 0 ? 1 : DIRECTIONS }, (_, index): [number, number] => {
      const angle = (2 * Math.PI * index) / DIRECTIONS;
      return [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
    }),
  );
  for (const [u, v] of around) {
    rayAt(u, v, element, lens);
    const hit = pick(cell, true);
    if (hit?.body != null) return hit;
  }
  return null;
}

function isShown(object: { visible: boolean; parent: unknown } | null): boolean {
  for (let at = object; at !== null; at = at.parent as typeof at) {
    if (!at.visible) return false;
  }
  return true;
}
