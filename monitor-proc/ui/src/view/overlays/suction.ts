// How much of what its suction can bear hangs at a tool.
import { Group, Vector3 } from "three";
import type { Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import type { Overlay } from "./overlay";

const HIGH = 0.8;
/** Beside the cup, which it does not cover (the style sheet shifts it). */
const ABOVE_M = 0.05;

export class Suction implements Overlay {
  readonly name = "suction";
  readonly root = new Group();

  update(cell: Cell, snapshot: Snapshot, labels: Labels): void {
    cell.scene.arms.forEach(({ name, gripper }, index) => {
      const arm = snapshot.arms[index];
      if (arm === undefined || gripper === null || gripper.finger_joints.length > 0) return;
      const [x, y, z] = arm.tcp;
      const load = Math.min(Math.max(arm.load, 0), 1);
      if (!arm.attached) return;
      const text = `load ${(100 * load).toFixed(0)} %`;
      const kind = load > HIGH ? "load high" : "load";
      const label = labels.say(`suction ${name}`, text, new Vector3(x, y, z + ABOVE_M), kind);
      label.style.setProperty("--load", `${(100 * load).toFixed(0)}%`);
    });
  }

  reset(): void {}
}
