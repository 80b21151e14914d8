// How near the load of a suction cup is to its break limit: a ring around the cup
// and the percentage beside it.
import { Box3, Group, type Object3D, Quaternion, Vector3 } from "three";
import type { ArmState, Snapshot } from "../../net/snapshot";
import { place } from "../body";
import type { Cell } from "../cell";
import type { About, Labels } from "../labels";
import type { Overlay } from "./overlay";
import { Ring } from "./ring";

/** Shares of the limit from which the load is amber and red. */
const TONES: [number, number, string][] = [
  [0.8, 0xe5534b, "very"],
  [0.5, 0xf0a53a, "near"],
  [0, 0x3f9d6b, ""],
];
/** Beside the cup, which it does not cover. */
const ABOVE_M = 0.05;
const RING_AXIS = new Vector3(0, 0, 1);

/** Points on the way from one link to the next one. */
const PER_LINK = 5;
/** Of more objects none is told apart. */
const MANY = 12;

/** The object and its cup, which the text is about, and the arm. */
function about(cell: Cell, index: number, { held, tcp }: ArmState): About {
  const body = cell.body(cell.scene.objects[held ?? -1]?.name ?? "");
  const corners = body == null ? [] : cornersOf(body.group);
  const links = cell.robot(index)?.chain() ?? [];
  const tool = new Vector3(...tcp.slice(0, 3));
  const wrist = links.slice(0, 1);
  const near = [tool, ...links].flatMap((at, link, all) => {
    const next = all[link + 1] ?? at;
    return Array.from({ length: PER_LINK }, (_, step) => at.clone().lerp(next, step / PER_LINK));
  });
  const others = cell.bodies.filter((other) => other !== body && other.group.visible);
  // A text on another object would be taken for one about it; a heap is one thing.
  const beside = others.length > MANY ? [] : others.flatMap(({ group }) => [group.position, ...cornersOf(group)]);
  return { shape: [...corners, ...wrist, tool], near: [...near, ...beside] };
}

/** The corners of the box around `group`. */
function cornersOf(group: Object3D): Vector3[] {
  const box = new Box3().setFromObject(group);
  return [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => corner(box, bits));
}

/** One of the eight corners of `box`. */
function corner({ min, max }: Box3, bits: number): Vector3 {
  const side = (axis: number) => ((bits >> axis) & 1) === 1;
  return new Vector3(side(0) ? max.x : min.x, side(1) ? max.y : min.y, side(2) ? max.z : min.z);
}

export class Suction implements Overlay {
  readonly name = "suction";
  readonly root = new Group();
  private readonly rings: Ring[] = [];

  update(cell: Cell, snapshot: Snapshot, labels: Labels): void {
    for (const { root } of this.rings) root.visible = false;
    cell.scene.arms.forEach(({ name, gripper }, index) => {
      const arm = snapshot.arms[index];
      // A cup that only touches an object carries no load.
      if (arm === undefined || gripper?.kind !== "suction" || arm.held === null) return;
      const held = cell.scene.objects[arm.held]?.name ?? "";
      const load = Math.min(Math.max(arm.load, 0), 1);
      const [, colour = 0, tone = ""] = TONES.find(([from]) => load >= from) ?? [];
      const ring = (this.rings[index] ??= this.ring());
      ring.root.visible = true;
      place(ring.root, arm.tcp);
      const axis = new Vector3(...(gripper.axis ?? [1, 0, 0])).normalize();
      ring.root.quaternion.multiply(new Quaternion().setFromUnitVectors(RING_AXIS, axis));
      ring.show(load, colour);
      const at = new Vector3(...arm.tcp.slice(0, 3)).setZ(arm.tcp[2] + ABOVE_M);
      const text = `${held}: suction at ${(100 * load).toFixed(0)} % of limit`;
      const label = labels.show(`suction ${name}`, text, at, `load ${tone}`, about(cell, index, arm));
      label.style.setProperty("--load", `${(100 * load).toFixed(0)}%`);
    });
  }

  reset(): void {
    this.root.clear();
    this.rings.length = 0;
  }

  private ring(): Ring {
    const ring = new Ring();
    this.root.add(ring.root);
    return ring;
  }
}
