// The target's frame, the measured tool frame, and the way between them.
import { EdgesGeometry, Group, LineBasicMaterial, LineSegments, type Mesh, OctahedronGeometry, Vector3 } from "three";
import type { Pose } from "../../net/protocol";
import { isUnreachable, type PlannedPath, type Snapshot } from "../../net/snapshot";
import { place } from "../body";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import { type Overlay, plainPaint } from "./overlay";
import { Strokes } from "./strokes";
import { triad } from "./triad";

const MOST_ARMS = 8;
/** Pieces of a path. */
const MOST_PIECES = 23;
const WAY = 0xffd166;
/** Of the mark of a target that a person sets (m). */
const MARK_M = 0.035;

function point(pose: Pose): Vector3 {
  return new Vector3(pose[0], pose[1], pose[2]);
}

export class Targets implements Overlay {
  readonly name = "targets";
  readonly root = new Group();
  private readonly goals: Mesh[] = [];
  private readonly tools: Mesh[] = [];
  private readonly ways = new Strokes(MOST_ARMS, WAY);
  private readonly paths = new Strokes(MOST_ARMS * MOST_PIECES, 0x4cc9f0);

  constructor() {
    this.root.add(this.ways.lines, this.paths.lines);
  }

  update(cell: Cell, snapshot: Snapshot, labels: Labels): void {
    this.ways.clear();
    this.paths.clear();
    snapshot.arms.forEach((arm, index) => {
      if (index >= MOST_ARMS) return;
      const goal = (this.goals[index] ??= this.goal(cell.scene.task.kind === "reach"));
      const tool = (this.tools[index] ??= this.frame(0.05, 0.0016));
      place(tool, arm.tcp);
      goal.visible = arm.targetValid;
      if (!arm.targetValid) return;
      place(goal, arm.target);
      if (arm.path === null) this.ways.add(point(arm.tcp), point(arm.target));
      else this.drawPath(arm.tcp, arm.path);
      if (!isUnreachable(arm)) return;
      const name = cell.scene.arms[index]?.name ?? String(index);
      const why = arm.notReached ?? "not reachable";
      const away = `${why}: ${(1000 * arm.positionError).toFixed(0)} mm away`;
      labels.show(`unreachable ${name}`, away, point(arm.target), "number kept");
    });
  }

  reset(): void {
    this.root.remove(...this.goals, ...this.tools);
    this.goals.length = 0;
    this.tools.length = 0;
    this.ways.clear();
    this.paths.clear();
  }

  /** The rest of a path, from the tool to its end. */
  private drawPath(tcp: Pose, { done, points }: PlannedPath): void {
    const left = points.slice(Math.ceil(done * (points.length - 1))).map(([x, y, z]) => new Vector3(x, y, z));
    let from = point(tcp);
    for (const to of left) {
      this.paths.add(from, to);
      from = to;
    }
  }

  /** `marked`: also where it is at the tool it can be told from the tool's frame. A recording has no handles there. */
  private goal(marked: boolean): Mesh {
    const goal = this.frame(0.09, 0.0028);
    if (!marked) return goal;
    const paint = new LineBasicMaterial({ color: WAY, ...plainPaint(true) });
    const mark = new LineSegments(new EdgesGeometry(new OctahedronGeometry(MARK_M)), paint);
    mark.name = "target mark";
    mark.renderOrder = 10;
    mark.raycast = () => {};
    goal.add(mark);
    return goal;
  }

  private frame(length: number, thickness: number): Mesh {
    const mesh = triad(length, thickness, true);
    this.root.add(mesh);
    return mesh;
  }
}
