// An arrow for the force of every contact, and one of 10 N to compare with.
import {
  ConeGeometry,
  DynamicDrawUsage,
  Group,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  Quaternion,
  Vector3,
} from "three";
import { nameOf } from "../../net/contacts";
import type { Contact, Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import { type Overlay, plainPaint } from "./overlay";
import { Strokes } from "./strokes";

const COLOUR = 0xff5fa2;
const MOST = 96;
/** Smaller forces are not drawn (N). */
const LEAST_N = 0.05;
/** The largest forces are written beside their arrows. */
const WRITTEN = 4;
/** Length of an arrow of 9 N (m); each further factor of ten is as much again. */
const DECADE_M = 0.05;
const HEAD_M = 0.014;
const LEGEND_N = 10;
/** Where the arrow of the legend is, beside the first arm (m). */
const LEGEND_BESIDE_M = 0.3;
const UP = new Vector3(0, 1, 0);

/** Length of the arrow of a force (m). */
function lengthOf(force_n: number): number {
  return DECADE_M * Math.log10(1 + force_n);
}

export class Forces implements Overlay {
  readonly name = "contact_forces";
  readonly root = new Group();
  private readonly shafts = new Strokes(MOST + 1, COLOUR);
  private readonly heads: InstancedMesh;
  private drawn = 0;

  constructor() {
    const paint = new MeshBasicMaterial({ color: COLOUR, ...plainPaint(true) });
    // Its tip is at the origin.
    const cone = new ConeGeometry(0.005, HEAD_M, 10).translate(0, -HEAD_M / 2, 0);
    this.heads = new InstancedMesh(cone, paint, MOST + 1);
    this.heads.instanceMatrix.setUsage(DynamicDrawUsage);
    this.heads.renderOrder = 9;
    this.heads.frustumCulled = false;
    this.heads.raycast = () => {};
    this.root.add(this.shafts.lines, this.heads);
  }

  update(cell: Cell, snapshot: Snapshot, labels: Labels): void {
    this.reset();
    const shown = snapshot.contacts.filter(({ force }) => Math.hypot(...force) > LEAST_N);
    for (const [index, contact] of shown.slice(0, MOST).entries()) {
      const { at, force, on } = oriented(contact);
      const tip = this.arrow(at, force);
      if (index >= WRITTEN) continue;
      labels.show(`force ${index}`, `${force.length().toFixed(1)} N on ${nameOf(cell.scene, on)}`, tip, "force");
    }
    if (shown.length > 0) this.legend(cell, labels);
    this.heads.count = this.drawn;
    this.heads.instanceMatrix.needsUpdate = true;
  }

  reset(): void {
    this.shafts.clear();
    this.drawn = 0;
    this.heads.count = 0;
  }

  private legend(cell: Cell, labels: Labels): void {
    const base = cell.robots[0]?.root.position;
    if (base === undefined) return;
    const at = base.clone().add(new Vector3(0, -LEGEND_BESIDE_M, 0));
    labels.show("force legend", `${LEGEND_N} N`, this.arrow(at, new Vector3(0, 0, LEGEND_N)), "force");
  }

  /** Draws an arrow; where its tip is. */
  private arrow(at: Vector3, force: Vector3): Vector3 {
    const direction = force.clone().normalize();
    const tip = at.clone().addScaledVector(direction, lengthOf(force.length()));
    this.shafts.add(at, tip);
    const turn = new Quaternion().setFromUnitVectors(UP, direction);
    this.heads.setMatrixAt(this.drawn, new Matrix4().compose(tip, turn, new Vector3(1, 1, 1)));
    this.drawn += 1;
    return tip;
  }
}

/** The force on the object of a contact; where there is none, on its first body. */
function oriented({ a, b, position, force }: Contact): { at: Vector3; force: Vector3; on: Contact["a"] } {
  const isOnB = a.kind !== "object" && b.kind === "object";
  const vector = new Vector3(...force).multiplyScalar(isOnB ? -1 : 1);
  return { at: new Vector3(...position), force: vector, on: isOnB ? b : a };
}
