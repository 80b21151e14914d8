// Contacts by body, with their forces.
import type { Scene, Vec3 } from "./protocol";
import type { Contact, ContactBody } from "./snapshot";

/** All contacts of one body with one partner. */
export interface Touch {
  partner: ContactBody;
  /** On the body (N, world frame). */
  force: Vec3;
  points: number;
}

export function norm(vector: Vec3): number {
  return Math.hypot(...vector);
}

function same(a: ContactBody, b: ContactBody): boolean {
  return a.kind === b.kind && a.index === b.index;
}

/** What `body` touches, the largest force first. */
export function touchesOf(contacts: Contact[], body: ContactBody): Touch[] {
  const all: Touch[] = [];
  for (const { a, b, force } of contacts) {
    const isA = same(a, body);
    if (!isA && !same(b, body)) continue;
    const partner = isA ? b : a;
    let touch = all.find((one) => same(one.partner, partner));
    if (touch === undefined) {
      touch = { partner, force: [0, 0, 0], points: 0 };
      all.push(touch);
    }
    touch.force = touch.force.map((sum, axis) => sum + (isA ? 1 : -1) * (force[axis] ?? 0)) as Vec3;
    touch.points += 1;
  }
  return all.sort((one, other) => norm(other.force) - norm(one.force));
}

/** The name of `body` in `scene`. */
export function nameOf(scene: Scene, { kind, index }: ContactBody): string {
  const list = { object: scene.objects, fixture: scene.fixtures, arm: scene.arms }[kind];
  return list[index]?.name ?? `${kind} ${index}`;
}
