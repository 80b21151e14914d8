// Poses that a person asks for by name: pointing down, above an object, a step along an axis.
import { Euler, Matrix4, Quaternion, Vector3 } from "three";
import type { Gripper, Pose, Shape } from "../net/protocol";
import type { Frame } from "./hand";

const DOWN = new Vector3(0, 0, -1);
/** Height of the tool above an object (m). */
export const ABOVE_M = 0.1;
/** The tool is not turned along a side of an object that is steeper than this. */
const LEVEL = 0.7;

export function rotationOf([, , , w, x, y, z]: Pose): Quaternion {
  return new Quaternion(x, y, z, w);
}

export function poseOf(at: Vector3, turn: Quaternion): Pose {
  const { x, y, z, w } = turn.clone().normalize();
  return [at.x, at.y, at.z, w, x, y, z];
}

function placeOf([x, y, z]: Pose): Vector3 {
  return new Vector3(x, y, z);
}

/** The direction in which a gripper grips, in the frame of its tool. */
export function gripAxis(gripper: Gripper | null): Vector3 {
  const axis = gripper?.kind === "suction" ? gripper.axis : undefined;
  return axis === undefined ? new Vector3(0, 0, 1) : new Vector3(...axis).normalize();
}

/** The tool at the same place, turned the shortest way so that it grips downwards. */
export function pointDown(tool: Pose, gripper: Gripper | null): Pose {
  const turn = rotationOf(tool);
  const now = gripAxis(gripper).applyQuaternion(turn);
  return poseOf(placeOf(tool), new Quaternion().setFromUnitVectors(now, DOWN).multiply(turn));
}

/** A step of `amount` (m or rad) along or about one of the axes x, y, z, roll, pitch, yaw. */
export function stepped(tool: Pose, axis: number, amount: number, frame: Frame): Pose {
  const unit = new Vector3().setComponent(axis % 3, 1);
  const turn = rotationOf(tool);
  if (axis < 3) {
    const step = frame === "tool" ? unit.applyQuaternion(turn) : unit;
    return poseOf(placeOf(tool).addScaledVector(step, amount), turn);
  }
  const about = new Quaternion().setFromAxisAngle(unit, amount);
  return poseOf(placeOf(tool), frame === "tool" ? turn.multiply(about) : about.multiply(turn));
}

/** Half of the extent of a shape along a direction in its own frame (m). */
function halfExtent(shape: Shape, along: Vector3): number {
  switch (shape.kind) {
    case "box":
    case "bin":
      return shape.size_m.reduce((sum, size, axis) => sum + (size / 2) * Math.abs(along.getComponent(axis)), 0);
    case "sphere":
      return shape.radius_m;
    case "cylinder":
      return shape.radius_m * Math.hypot(along.x, along.y) + (shape.length_m / 2) * Math.abs(along.z);
    case "capsule":
      return shape.radius_m + (shape.length_m / 2) * Math.abs(along.z);
    case "compound":
      return Math.max(
        ...shape.parts.map(({ shape: part, pose }) => {
          const local = along.clone().applyQuaternion(rotationOf(pose).invert());
          return halfExtent(part, local) + placeOf(pose).dot(along);
        }),
      );
  }
}

/** Height of the highest point of a body above its origin (m). */
export function topOf(shape: Shape, pose: Pose): number {
  return halfExtent(shape, new Vector3(0, 0, 1).applyQuaternion(rotationOf(pose).invert()));
}

/** A body and where it is. */
export interface Placed {
  shape: Shape;
  pose: Pose;
}

/** From the middle of `below` to that of `held` where it is `gap_m` above it (m, along z). */
function heightOver(held: Placed, below: Placed, gap_m: number): number {
  const down = DOWN.clone().applyQuaternion(rotationOf(held.pose).invert());
  return topOf(below.shape, below.pose) + gap_m + halfExtent(held.shape, down);
}

/** The tool, turned as it is, where the object that it holds is in the middle over another one, `gap_m` above it. */
export function over(tool: Pose, held: Placed, below: Placed, gap_m: number): Pose {
  const goal = placeOf(below.pose).add({ x: 0, y: 0, z: heightOver(held, below, gap_m) });
  return poseOf(placeOf(tool).add(goal).sub(placeOf(held.pose)), rotationOf(tool));
}

/** Directions of an object's level sides, from the world's x axis (rad). */
function sideAngle(pose: Pose): number {
  const turn = rotationOf(pose);
  const sides = [0, 1, 2].map((axis) => new Vector3().setComponent(axis, 1).applyQuaternion(turn));
  const side = sides.find(({ z }) => Math.abs(z) < LEVEL) ?? new Vector3(1, 0, 0);
  return Math.atan2(side.y, side.x);
}

/** Extent of an object across a level direction (m). */
function across(shape: Shape, pose: Pose, angle: number): number {
  const along = new Vector3(Math.cos(angle), Math.sin(angle), 0).applyQuaternion(rotationOf(pose).invert());
  return 2 * halfExtent(shape, along);
}

/**
 * The tool above an object, gripping downwards and turned along its sides: the quarter turn that is
 * nearest, of those at which the fingers are wide enough.
 */
export function above(tool: Pose, gripper: Gripper | null, shape: Shape, pose: Pose): Pose {
  const down = pointDown(tool, gripper);
  const turn = rotationOf(down);
  // The fingers close along y.
  const closing = new Vector3(0, 1, 0).applyQuaternion(turn);
  const level = Math.abs(closing.z) < LEVEL ? closing : new Vector3(0, 0, 1).applyQuaternion(turn);
  const now = Math.atan2(level.y, level.x);
  const quarter = Math.PI / 2;
  const turns = [0, 1, 2, 3].map((count) => {
    const angle = sideAngle(pose) + count * quarter;
    return { angle, by: wrapped(angle - now) };
  });
  const widest = gripper?.kind === "parallel" ? gripper.max_width_m : Infinity;
  const fits = turns.filter(({ angle }) => across(shape, pose, angle) <= widest);
  const best = (fits.length > 0 ? fits : turns).reduce((one, other) =>
    Math.abs(other.by) < Math.abs(one.by) ? other : one,
  );
  const about = new Quaternion().setFromEuler(new Euler(0, 0, best.by));
  return poseOf(placeOf(pose).setZ(pose[2] + topOf(shape, pose) + ABOVE_M), about.multiply(turn));
}

/** An angle between minus and plus half a turn (rad). */
function wrapped(angle: number): number {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

/** Angle between the orientations of two poses (rad). */
export function angleBetween(one: Pose, other: Pose): number {
  return rotationOf(one).angleTo(rotationOf(other));
}

/** Axes of a frame at a pose, as columns. */
export function axesOf(tool: Pose, frame: Frame): [Vector3, Vector3, Vector3] {
  const axes: [Vector3, Vector3, Vector3] = [new Vector3(), new Vector3(), new Vector3()];
  const turn = frame === "tool" ? rotationOf(tool) : new Quaternion();
  new Matrix4().makeRotationFromQuaternion(turn).extractBasis(...axes);
  return axes;
}
