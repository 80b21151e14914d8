// The names of objects and arms.
import { Group, Vector3 } from "three";
import type { Snapshot } from "../../net/snapshot";
import { halfHeight } from "../body";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import type { Overlay } from "./overlay";

const ABOVE_ARM_M = 0.06;

export class Names implements Overlay {
  readonly name = "names";
  readonly root = new Group();

  update(cell: Cell, _: Snapshot, labels: Labels): void {
    const at = new Vector3();
    for (const { name, shape, group } of cell.bodies) {
      if (!group.visible) continue;
      at.copy(group.position);
      at.z += halfHeight(shape);
      labels.show(`name ${name}`, name, at);
    }
    for (const robot of cell.robots) {
      at.copy(robot.root.position);
      at.z += ABOVE_ARM_M;
      labels.show(`arm ${robot.spec.name}`, robot.spec.name, at);
    }
  }

  reset(): void {}
}
