// The target's frame, the measured tool frame, and the way between them.
import { Group, type Mesh, Vector3 } from "three";
import type { Pose } from "../../net/protocol";
import { isUnreachable, type Snapshot } from "../../net/snapshot";
import { place } from "../body";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import type { Overlay } from "./overlay";
import { Strokes } from "./strokes";
import { triad } from "./triad";

const MOST_ARMS = 8;

function point(pose: Pose): Vector3 {
  return new Vector3(pose[0], pose[1], pose[2]);
}

export class Targets implements Overlay {
  readonly name = "targets";
  readonly root = new Group();
  private readonly goals: Mesh[] = [];
  private readonly tools: Mesh[] = [];
  private readonly ways = new Strokes(MOST_ARMS, 0xffd166);

  constructor() {
    this.root.add(this.ways.lines);
  }

  update(cell: Cell, snapshot: Snapshot, labels: Labels): void {
    this.ways.clear();
    snapshot.arms.forEach((arm, index) => {
      if (index >= MOST_ARMS) return;
      const goal = (this.goals[index] ??= this.frame(0.09, 0.0028));
      const tool = (this.tools[index] ??= this.frame(0.05, 0.0016));
      place(tool, arm.tcp);
      goal.visible = arm.targetValid;
      if (!arm.targetValid) return;
      place(goal, arm.target);
      this.ways.add(point(arm.tcp), point(arm.target));
      if (!isUnreachable(arm)) return;
      const name = cell.scene.arms[index]?.name ?? String(index);
      const away = `not reachable: ${(1000 * arm.positionError).toFixed(0)} mm away`;
      labels.say(`unreachable ${name}`, away, point(arm.target), "number");
    });
  }

  reset(): void {
    this.root.remove(...this.goals, ...this.tools);
    this.goals.length = 0;
    this.tools.length = 0;
    this.ways.clear();
  }

  private frame(length: number, thickness: number): Mesh {
    const mesh = triad(length, thickness, true);
    this.root.add(mesh);
    return mesh;
  }
}
