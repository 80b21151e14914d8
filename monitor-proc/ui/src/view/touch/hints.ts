// Names the actions of the mouse on the object under it.
import type { Store } from "../../net/store";
import type { Camera } from "../camera";
import type { Cell } from "../cell";
import type { Gizmo } from "./gizmo";
import { pick, rayAt } from "./pick";

/** The search for the object under the mouse takes time: not more often than this. */
const PERIOD_MS = 80;

export class Hints {
  private readonly line = document.createElement("div");
  private at: [number, number] | null = null;
  private timer = 0;

  constructor(
    private readonly element: HTMLElement,
    private readonly camera: Camera,
    private readonly store: Store,
    private readonly cell: () => Cell | null,
    private readonly gizmo: Gizmo,
  ) {
    this.line.className = "pointer-hint";
    this.line.hidden = true;
    element.append(this.line);
    element.addEventListener("pointermove", ({ pointerType, buttons, clientX, clientY }) => {
      if (pointerType !== "mouse" || buttons !== 0) this.leave();
      else this.look([clientX, clientY]);
    });
    element.addEventListener("pointerdown", () => this.leave());
    element.addEventListener("pointerleave", () => this.leave());
  }

  private leave(): void {
    clearTimeout(this.timer);
    this.timer = 0;
    this.show(null);
  }

  private look(at: [number, number]): void {
    this.at = at;
    if (this.timer !== 0) return;
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      if (this.at !== null) this.show(this.words(...this.at));
    }, PERIOD_MS);
  }

  private show(text: string | null): void {
    this.line.hidden = text === null;
    if (text !== null && this.line.textContent !== text) this.line.textContent = text;
  }

  private words(x: number, y: number): string | null {
    const cell = this.cell();
    if (cell === null) return null;
    const frame = this.element.getBoundingClientRect();
    const handle = this.gizmo.hint(x - frame.left, y - frame.top, frame.width, frame.height);
    if (handle !== null) return handle;
    rayAt(x, y, this.element, this.camera.lens);
    const hit = pick(cell);
    const looks = this.store.hello?.role === "viewer";
    if (hit?.body != null) {
      const { name } = hit.body;
      if (looks) return `Click selects ${name}`;
      return `Shift+drag moves ${name}, with Ctrl up and down; click selects; double click looks closer`;
    }
    const arm = hit?.arm == null ? undefined : cell.scene.arms[hit.arm]?.name;
    if (arm === undefined) return null;
    return `Click selects ${arm} and shows the handle of its target; double click looks closer`;
  }
}
