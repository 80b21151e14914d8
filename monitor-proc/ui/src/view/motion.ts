// Whether two states of the cell look the same.
import { type ArmState, isUnreachable, type ObjectState, type Snapshot } from "../net/snapshot";

/** A motion of less than this part of a pixel is not seen. */
const SEEN_PX = 0.25;
/** Bounds of a motion that is not visible, at any distance (m). */
const [LEAST_M, MOST_M] = [1e-4, 1.5e-3];

/** The largest motion that is not seen where a pixel is `pixel_m` wide (m; rad of a joint that moves an arm of a metre). */
export function unseen(pixel_m: number): number {
  return Math.min(Math.max(SEEN_PX * pixel_m, LEAST_M), MOST_M);
}

/** Of a suction cup's load. */
const SEEN_LOAD = 0.005;

/** Of the contacts' forces together: in N, and as a share. */
const SEEN_FORCE_N = 0.5;
const SEEN_FORCE = 0.1;

/** Whether the pictures of `before` and `now` differ by more than `least` (m, rad). */
export function looksOther(before: Snapshot, now: Snapshot, least: number): boolean {
  return (
    before.flags !== now.flags ||
    before.arms.length !== now.arms.length ||
    before.objects.length !== now.objects.length ||
    before.arms.some((arm, index) => armDiffers(arm, now.arms[index] as ArmState, least)) ||
    forceDiffers(force(before), force(now)) ||
    before.objects.some((object, index) => objectDiffers(object, now.objects[index] as ObjectState, least))
  );
}

function force({ contacts }: Snapshot): number {
  return contacts.reduce((sum, contact) => sum + Math.hypot(...contact.force), 0);
}

function forceDiffers(before: number, now: number): boolean {
  return Math.abs(before - now) > SEEN_FORCE_N + SEEN_FORCE * before;
}

function objectDiffers(before: ObjectState, now: ObjectState, least: number): boolean {
  return before.flags !== now.flags || differ(before.pose, now.pose, least);
}

function armDiffers(before: ArmState, now: ArmState, least: number): boolean {
  return (
    differ(before.positions, now.positions, least) ||
    differ(before.setpoints, now.setpoints, least) ||
    differ(before.tcp, now.tcp, least) ||
    differ(before.target, now.target, least) ||
    before.targetValid !== now.targetValid ||
    before.goalActive !== now.goalActive ||
    before.attached !== now.attached ||
    before.held !== now.held ||
    isUnreachable(before) !== isUnreachable(now) ||
    before.notReached !== now.notReached ||
    (before.path === null) !== (now.path === null) ||
    before.obstacleMask !== now.obstacleMask ||
    Math.abs(before.clearance - now.clearance) > least ||
    Math.abs(before.load - now.load) > SEEN_LOAD
  );
}

function differ(before: ArrayLike<number>, now: ArrayLike<number>, least: number): boolean {
  for (let at = 0; at < before.length; at++) {
    if (Math.abs((before[at] ?? 0) - (now[at] ?? 0)) > least) return true;
  }
  return false;
}
