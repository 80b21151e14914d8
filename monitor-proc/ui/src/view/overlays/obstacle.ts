// Obstacles of the motion policies: which count now, and how far they are.
import { Matrix4, Quaternion, Vector3 } from "three";
import type { Pose, Scene, Shape } from "../../net/protocol";
import type { Snapshot } from "../../net/snapshot";

type Obstacle = Scene["fixtures"][number];

/** The bit that says that all obstacles count. */
const ALL = 31;

function counts(mask: number, bit: number): boolean {
  return mask >>> ALL === 1 || (bit < ALL && ((mask >>> bit) & 1) === 1);
}

/** The obstacles that any arm, or the arm `only`, avoids now. */
export function activeObstacles(scene: Scene, snapshot: Snapshot, only?: number): Obstacle[] {
  const arms = only === undefined ? snapshot.arms : snapshot.arms.slice(only, only + 1);
  return scene.fixtures.filter(({ obstacle }) => {
    if (obstacle === null) return false;
    return arms.some(({ obstacleMask }) => counts(obstacleMask, obstacle));
  });
}

function matrixOf(pose: Pose): Matrix4 {
  return new Matrix4().compose(
    new Vector3(pose[0], pose[1], pose[2]),
    new Quaternion(pose[4], pose[5], pose[6], pose[3]),
    new Vector3(1, 1, 1),
  );
}

/** The point of a shape's surface nearest to `at`, in the shape's frame, from outside. */
function nearest(shape: Exclude<Shape, { kind: "compound" }>, at: Vector3): Vector3 {
  switch (shape.kind) {
    case "box":
    case "bin": {
      const half = new Vector3(...shape.size_m).multiplyScalar(0.5);
      return at.clone().clamp(half.clone().negate(), half);
    }
    case "sphere":
      return at.clone().setLength(Math.min(at.length(), shape.radius_m));
    case "cylinder": {
      const away = Math.hypot(at.x, at.y);
      const scale = away > shape.radius_m ? shape.radius_m / away : 1;
      const half = shape.length_m / 2;
      const z = Math.min(Math.max(at.z, -half), half);
      return new Vector3(at.x * scale, at.y * scale, z);
    }
    case "capsule": {
      const half = shape.length_m / 2;
      const axis = new Vector3(0, 0, Math.min(Math.max(at.z, -half), half));
      const away = at.clone().sub(axis);
      return axis.add(away.setLength(Math.min(away.length(), shape.radius_m)));
    }
  }
}

/** The point of the body nearest to `at`, both in the world (m). */
export function nearestPoint(shape: Shape, pose: Pose, at: Vector3): Vector3 {
  const matrix = matrixOf(pose);
  const local = at.clone().applyMatrix4(matrix.clone().invert());
  if (shape.kind !== "compound") return nearest(shape, local).applyMatrix4(matrix);
  let best: Vector3 | null = null;
  for (const { shape: inner, pose: innerPose } of shape.parts) {
    const found = nearestPoint(inner, innerPose, local);
    if (best === null || found.distanceTo(local) < best.distanceTo(local)) best = found;
  }
  return (best ?? new Vector3()).applyMatrix4(matrix);
}
