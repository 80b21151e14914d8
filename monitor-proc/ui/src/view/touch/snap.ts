// While Shift is down, an outline shows the body that a press would grab.
import { Group } from "three";
import { outline } from "../body";
import type { Camera } from "../camera";
import type { Body, Cell } from "../cell";
import { bodyNear } from "./pick";

const COLOUR = 0x4cc9ff;
/** Wider than the rims of the selection and of a touched object. */
const RIM_M = 0.007;
/** Looking for a body takes a moment: not more often than this. */
const PERIOD_MS = 60;

export class Snap {
  readonly root = new Group();
  private body: Body | null = null;
  private at: [number, number] | null = null;
  private timer = 0;

  constructor(
    private readonly element: HTMLElement,
    private readonly camera: Camera,
    private readonly cell: () => Cell | null,
    private readonly pulls: () => boolean,
    private readonly changed: () => void,
  ) {
    element.addEventListener("pointermove", ({ pointerType, shiftKey, clientX, clientY }) => {
      this.at = pointerType === "mouse" ? [clientX, clientY] : null;
      this.look(shiftKey);
    });
    element.addEventListener("pointerleave", () => {
      this.at = null;
      this.show(null);
    });
    addEventListener("keydown", ({ key }) => {
      if (key === "Shift") this.look(true);
    });
    addEventListener("keyup", ({ key }) => {
      if (key === "Shift") this.show(null);
    });
    addEventListener("blur", () => this.show(null));
  }

  /** The outline goes along with its body. */
  update(): void {
    if (this.body === null) return;
    this.root.position.copy(this.body.group.position);
    this.root.quaternion.copy(this.body.group.quaternion);
  }

  private look(shift: boolean): void {
    if (!shift) return this.show(null);
    if (this.timer !== 0 || this.pulls()) return;
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      const cell = this.cell();
      if (cell === null || this.at === null || this.pulls()) return;
      this.show(bodyNear(...this.at, this.element, this.camera.lens, cell)?.body ?? null);
    }, PERIOD_MS);
  }

  private show(body: Body | null): void {
    if (body === null) {
      clearTimeout(this.timer);
      this.timer = 0;
    }
    if (body === this.body) return;
    this.body = body;
    this.root.clear();
    if (body !== null) this.root.add(outline(body.shape, COLOUR, RIM_M));
    this.update();
    this.changed();
  }
}
