// The keyboard in the view: arrows and Page Up and Down move or turn the target of the arm.
import type { Vector3 } from "three";
import { Vector3 as Vector } from "three";
import { axesOf } from "../../hand/aims";
import type { Hand } from "../../hand/hand";
import type { Jog } from "../../hand/jog";
import type { Camera } from "../camera";
import type { Gizmo } from "./gizmo";

/** Where a key moves: to the right, away, or up, as it is seen; and the way along it. */
const KEYS: Record<string, ["right" | "away" | "up", number]> = {
  ArrowLeft: ["right", -1],
  ArrowRight: ["right", 1],
  ArrowDown: ["away", -1],
  ArrowUp: ["away", 1],
  PageDown: ["up", -1],
  PageUp: ["up", 1],
};

const LABEL =
  "3D view. While the task is paused, the arrow keys, Page Up and Page Down move the target of the tool; E turns, T moves; Shift is fine";

export class Keys {
  constructor(
    canvas: HTMLElement,
    private readonly camera: Camera,
    private readonly gizmo: Gizmo,
    private readonly hand: Hand,
    private readonly jog: Jog,
    private readonly tell: (text: string) => void,
  ) {
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", LABEL);
    canvas.addEventListener("keydown", (event) => this.press(event));
    canvas.addEventListener("keyup", () => this.jog.release());
    canvas.addEventListener("blur", () => this.jog.release());
  }

  private press(event: KeyboardEvent): void {
    const way = KEYS[event.key];
    if (way === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    // A press is one step; in the mode that holds, it lasts until the key is released.
    if (event.repeat) return;
    const refusal = this.hand.refusal();
    if (refusal !== null) {
      this.tell(`not now: ${refusal}`);
      return;
    }
    const [axis, sign] = this.axis(way[0]);
    const turns = this.gizmo.turns ? 3 : 0;
    this.jog.press(this.gizmo.arm, axis + turns, sign * way[1], event.shiftKey);
  }

  /** The axis of the frame that is nearest to a direction of the picture, and its sign. */
  private axis(direction: "right" | "away" | "up"): [number, number] {
    const tool = this.hand.pose(this.gizmo.arm);
    const axes = tool === null ? null : axesOf(tool, this.hand.frame);
    if (axes === null) return [0, 1];
    const { lens } = this.camera;
    const right = new Vector(1, 0, 0).applyQuaternion(lens.quaternion);
    const up = new Vector(0, 0, 1);
    const away = up.clone().cross(right);
    const free = new Set([0, 1, 2]);
    const nearest = (to: Vector3): [number, number] => {
      const rated = [...free].map((axis) => [axis, axes[axis as 0 | 1 | 2].dot(to)] as const);
      const [axis, along] = rated.reduce((one, other) => (Math.abs(other[1]) > Math.abs(one[1]) ? other : one));
      free.delete(axis);
      return [axis, along < 0 ? -1 : 1];
    };
    const found = { up: nearest(up), right: nearest(right), away: nearest(away) };
    return found[direction];
  }
}
