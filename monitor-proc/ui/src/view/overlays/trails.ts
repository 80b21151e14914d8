// Where each tool was in the last ten seconds, fading with age.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Group, Line, LineBasicMaterial } from "three";
import type { Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import type { Overlay } from "./overlay";

const KEPT_S = 10;
const MOST_POINTS = 600;
/** A step that no arm makes between two pictures: the time was set (m). */
const JUMP_M = 0.2;
const COLOURS = [
  [0.16, 0.82, 1],
  [1, 0.55, 0.2],
  [0.6, 1, 0.4],
] as const;

interface Point {
  time: number;
  at: [number, number, number];
}

class Trail {
  readonly line: Line;
  private points: Point[] = [];
  private readonly places = new BufferAttribute(new Float32Array(3 * MOST_POINTS), 3);
  private readonly colours = new BufferAttribute(new Float32Array(4 * MOST_POINTS), 4);

  constructor(private readonly colour: readonly [number, number, number]) {
    this.places.setUsage(DynamicDrawUsage);
    this.colours.setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.places);
    geometry.setAttribute("color", this.colours);
    const paint = new LineBasicMaterial({ vertexColors: true, transparent: true, fog: false });
    paint.toneMapped = false;
    this.line = new Line(geometry, paint);
    this.line.frustumCulled = false;
    this.line.raycast = () => {};
  }

  add(time: number, at: [number, number, number]): void {
    const last = this.points.at(-1);
    if (last !== undefined) {
      const step = Math.hypot(at[0] - last.at[0], at[1] - last.at[1], at[2] - last.at[2]);
      if (time < last.time || step > JUMP_M) this.points = [];
      else if (time === last.time) return;
    }
    this.points.push({ time, at });
    const first = this.points.findIndex((point) => point.time > time - KEPT_S);
    this.points.splice(0, Math.max(first, this.points.length - MOST_POINTS));
    this.draw(time);
  }

  private draw(now: number): void {
    this.points.forEach(({ time, at }, index) => {
      const fresh = 1 - (now - time) / KEPT_S;
      this.places.setXYZ(index, ...at);
      this.colours.setXYZW(index, ...this.colour, fresh);
    });
    this.places.needsUpdate = true;
    this.colours.needsUpdate = true;
    this.line.geometry.setDrawRange(0, this.points.length);
  }
}

export class Trails implements Overlay {
  readonly name = "trails";
  readonly root = new Group();
  private readonly trails: Trail[] = [];

  update(_: Cell, snapshot: Snapshot): void {
    snapshot.arms.forEach(({ tcp }, index) => {
      let trail = this.trails[index];
      if (trail === undefined) {
        trail = new Trail(COLOURS[index % COLOURS.length] ?? COLOURS[0]);
        this.trails[index] = trail;
        this.root.add(trail.line);
      }
      trail.add(snapshot.time, [tcp[0], tcp[1], tcp[2]]);
    });
  }

  reset(): void {
    this.root.clear();
    this.trails.length = 0;
  }
}
