// A line from each arm's nearest sphere to each obstacle, with its length.
import { Group, type Vector3 } from "three";
import type { Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import { type Ball, balls } from "./ball";
import { activeObstacles, nearestPoint } from "./obstacle";
import type { Overlay } from "./overlay";
import { Strokes } from "./strokes";

const MOST_LINES = 64;
/** Farther obstacles clutter the picture (m). */
const FAR_M = 1.2;

interface Gap {
  from: Vector3;
  to: Vector3;
  length: number;
}

export class Distances implements Overlay {
  readonly name = "distances";
  readonly root = new Group();
  private readonly lines = new Strokes(MOST_LINES, 0xff6b5e);

  constructor() {
    this.root.add(this.lines.lines);
  }

  update(cell: Cell, snapshot: Snapshot, labels: Labels): void {
    this.lines.clear();
    cell.robots.forEach((robot) => {
      const all = balls(robot);
      const arm = cell.scene.arms.indexOf(robot.spec);
      for (const { name, shape, pose } of activeObstacles(cell.scene, snapshot, arm)) {
        const gap = smallest(all, (at) => nearestPoint(shape, pose, at));
        if (gap === null || gap.length > FAR_M) continue;
        this.lines.add(gap.from, gap.to);
        const middle = gap.from.clone().lerp(gap.to, 0.5);
        const text = `${(1000 * gap.length).toFixed(0)} mm`;
        labels.show(`distance ${arm} ${name}`, text, middle, "number");
      }
    });
  }

  reset(): void {
    this.lines.clear();
  }
}

function smallest(all: Ball[], nearest: (at: Vector3) => Vector3): Gap | null {
  let best: Gap | null = null;
  for (const { centre, radius } of all) {
    const to = nearest(centre);
    const length = centre.distanceTo(to) - radius;
    if (best !== null && best.length <= length) continue;
    const from = centre.clone().lerp(to, radius / Math.max(centre.distanceTo(to), radius, 1e-9));
    best = { from, to, length };
  }
  return best;
}
