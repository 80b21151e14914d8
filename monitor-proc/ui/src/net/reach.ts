// Targets to try with an arm that follows a person's target: the panel offers them, and the picture has room for them.
import type { ArmSpec, Vec3 } from "./protocol";

/** In lengths of the stretched arm, from its base. */
const EXAMPLES: [string, Vec3][] = [
  ["In front", [0.34, 0, 0.34]],
  ["Low, to the side", [0.3, -0.24, 0.2]],
  ["Out of reach", [1.3, 0, 0.34]],
];
const GRID_M = 0.05;

/** Names and places (m, world frame). */
export function exampleTargets(spec: ArmSpec): [string, Vec3][] {
  const length = stretched(spec);
  const placed = (share: number, axis: number) => round((spec.base.position[axis] ?? 0) + share * length);
  return EXAMPLES.map(([name, shares]) => [name, shares.map(placed) as Vec3]);
}

/** Length of the arm from joint to joint (m): no point farther away can be reached. */
function stretched({ urdf, joints, arm_joints }: ArmSpec): number {
  const names = new Set(joints.slice(0, arm_joints).map(({ name }) => name));
  const found = new DOMParser().parseFromString(urdf, "application/xml").querySelectorAll("joint");
  let length = 0;
  for (const joint of found) {
    if (!names.has(joint.getAttribute("name") ?? "")) continue;
    const offset = (joint.querySelector("origin")?.getAttribute("xyz") ?? "").trim().split(/\s+/).map(Number);
    if (offset.every(Number.isFinite)) length += Math.hypot(...offset);
  }
  return length > 0 ? length : 1;
}

function round(metres: number): number {
  return Number((Math.round(metres / GRID_M) * GRID_M).toFixed(2));
}
