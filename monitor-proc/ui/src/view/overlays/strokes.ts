// Lines whose ends change with every picture.
import {
  BufferAttribute,
  BufferGeometry,
  DynamicDrawUsage,
  LineBasicMaterial,
  LineSegments,
  type Vector3,
} from "three";
import { plainPaint } from "./overlay";

export class Strokes {
  readonly lines: LineSegments;
  private readonly ends: BufferAttribute;
  private count = 0;

  /** Room for `most` lines. */
  constructor(most: number, colour: number, over = true) {
    this.ends = new BufferAttribute(new Float32Array(6 * most), 3);
    this.ends.setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.ends);
    this.lines = new LineSegments(geometry, new LineBasicMaterial({ color: colour, ...plainPaint(over) }));
    this.lines.renderOrder = 9;
    this.lines.frustumCulled = false;
    this.lines.raycast = () => {};
    this.clear();
  }

  clear(): void {
    this.count = 0;
    this.lines.geometry.setDrawRange(0, 0);
  }

  add(from: Vector3, to: Vector3): void {
    if (2 * this.count + 1 >= this.ends.count) return;
    this.ends.setXYZ(2 * this.count, from.x, from.y, from.z);
    this.ends.setXYZ(2 * this.count + 1, to.x, to.y, to.z);
    this.count += 1;
    this.ends.needsUpdate = true;
    this.lines.geometry.setDrawRange(0, 2 * this.count);
  }
}
