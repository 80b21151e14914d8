// Whether two states of the cell look the same.
import { type ArmState, isUnreachable, type ObjectState, type Snapshot } from "../net/snapshot";

/** Less is not seen (m, rad, parts of a quaternion). */
const SEEN = 1e-4;
/** Of a suction cup's load. */
const SEEN_LOAD = 0.005;

/** Of the contacts' forces together: in N, and as a share. */
const SEEN_FORCE_N = 0.5;
const SEEN_FORCE = 0.1;

/** Whether what is drawn of `now` differs from what is drawn of `before`. */
export function looksOther(before: Snapshot, now: Snapshot): boolean {
  return (
    before.flags !== now.flags ||
    before.arms.length !== now.arms.length ||
    before.objects.length !== now.objects.length ||
    before.arms.some((arm, index) => armDiffers(arm, now.arms[index] as ArmState)) ||
    forceDiffers(force(before), force(now)) ||
    before.objects.some((object, index) => objectDiffers(object, now.objects[index] as ObjectState))
  );
}

function force({ contacts }: Snapshot): number {
  return contacts.reduce((sum, contact) => sum + Math.hypot(...contact.force), 0);
}

function forceDiffers(before: number, now: number): boolean {
  return Math.abs(before - now) > SEEN_FORCE_N + SEEN_FORCE * before;
}

function objectDiffers(before: ObjectState, now: ObjectState): boolean {
  return before.flags !== now.flags || differ(before.pose, now.pose);
}

function armDiffers(before: ArmState, now: ArmState): boolean {
  return (
    differ(before.positions, now.positions) ||
    differ(before.setpoints, now.setpoints) ||
    differ(before.tcp, now.tcp) ||
    differ(before.target, now.target) ||
    before.targetValid !== now.targetValid ||
    before.goalActive !== now.goalActive ||
    before.attached !== now.attached ||
    before.held !== now.held ||
    isUnreachable(before) !== isUnreachable(now) ||
    before.notReached !== now.notReached ||
    (before.path === null) !== (now.path === null) ||
    before.obstacleMask !== now.obstacleMask ||
    Math.abs(before.clearance - now.clearance) > SEEN ||
    Math.abs(before.load - now.load) > SEEN_LOAD
  );
}

function differ(before: ArrayLike<number>, now: ArrayLike<number>): boolean {
  for (let at = 0; at < before.length; at++) {
    if (Math.abs((before[at] ?? 0) - (now[at] ?? 0)) > SEEN) return true;
  }
  return false;
}
