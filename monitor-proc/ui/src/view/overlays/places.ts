// The places that the task's description names, as flat outlines where an object goes.
import {
  BufferGeometry,
  Color,
  DoubleSide,
  Group,
  LineBasicMaterial,
  LineLoop,
  Mesh,
  MeshBasicMaterial,
  RingGeometry,
  Vector3,
} from "three";
import type { Scene, Shape } from "../../net/protocol";
import type { Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import { type Overlay, plainPaint } from "./overlay";

const COLOUR = new Color(0xffd166);
const LINE_M = 0.004;
/** Between an object and the outline of its place (m). */
const AROUND_M = 0.008;
/** Above the surface under the object, so that both are not drawn in one plane (m). */
const ABOVE_M = 0.0008;
const USUAL_HALF_M = 0.03;
const CORNERS = 4;

/** Positions in the world (m), by name. */
function placesOf({ task }: Scene): [string, number[]][] {
  const all = task.place;
  if (typeof all !== "object" || all === null) return [];
  return Object.entries(all).flatMap(([name, place]: [string, unknown]) => {
    const at: unknown = typeof place === "object" && place !== null && "position_m" in place ? place.position_m : null;
    const isPoint = Array.isArray(at) && at.length === 3 && at.every((one) => typeof one === "number");
    return isPoint ? [[name, at as number[]]] : [];
  });
}

/** Half the width of the widest object (m). */
function halfWidth({ objects }: Scene): number {
  const half = (shape: Shape) => ("size_m" in shape ? Math.max(shape.size_m[0], shape.size_m[1]) / 2 : USUAL_HALF_M);
  return Math.max(...objects.map(({ shape }) => half(shape)), 0) || USUAL_HALF_M;
}

/** The corners of a square around the origin, `radius` from it (m). */
function corners(radius: number): BufferGeometry {
  const angles = Array.from({ length: CORNERS }, (_, corner) => Math.PI / 4 + (2 * Math.PI * corner) / CORNERS);
  const points = angles.map((angle) => new Vector3(radius * Math.cos(angle), radius * Math.sin(angle), 0));
  return new BufferGeometry().setFromPoints(points);
}

export class Places implements Overlay {
  readonly name = "targets";
  readonly root = new Group();
  private scene: Scene | null = null;

  update({ scene }: Cell, _: Snapshot): void {
    if (scene === this.scene) return;
    this.scene = scene;
    this.root.clear();
    const half = halfWidth(scene) + AROUND_M;
    const paint = new MeshBasicMaterial({ color: COLOUR, side: DoubleSide, ...plainPaint(false) });
    const line = new LineBasicMaterial({ color: COLOUR, ...plainPaint(false) });
    for (const [name, [x = 0, y = 0, z = 0]] of placesOf(scene)) {
      // A ring of four corners is a square.
      const square = new RingGeometry(Math.SQRT2 * half, Math.SQRT2 * (half + LINE_M), CORNERS, 1, Math.PI / 4);
      const outline = new Mesh(square, paint);
      outline.name = `place ${name}`;
      outline.position.set(x, y, z + ABOVE_M);
      outline.raycast = () => {};
      // A line is not thinner than a pixel, whatever the resolution.
      const edge = new LineLoop(corners(Math.SQRT2 * (half + LINE_M / 2)), line);
      edge.raycast = () => {};
      outline.add(edge);
      this.root.add(outline);
    }
  }

  reset(): void {
    this.scene = null;
    this.root.clear();
  }
}
