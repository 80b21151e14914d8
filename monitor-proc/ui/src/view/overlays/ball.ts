// The spheres that stand for an arm in collision avoidance, in the world.
import { Vector3 } from "three";
import type { Robot } from "../robots/robot";

export interface Ball {
  centre: Vector3;
  radius: number;
}

/** All spheres of `robot` as it is drawn now (m). */
export function balls(robot: Robot): Ball[] {
  robot.root.updateWorldMatrix(true, true);
  const found: Ball[] = [];
  for (const { link, center, radius } of robot.spec.spheres) {
    const frame = robot.link(link);
    if (frame === null) continue;
    found.push({ centre: new Vector3(...center).applyMatrix4(frame.matrixWorld), radius });
  }
  return found;
}
