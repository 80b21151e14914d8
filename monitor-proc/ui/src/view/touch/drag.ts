// Shift-drag pulls a body by a spring; the monitor asks physics for it.
import { Group, Mesh, MeshBasicMaterial, Plane, SphereGeometry, Vector3 } from "three";
import type { Vec3 } from "../../net/protocol";
import type { Store } from "../../net/store";
import { FLAG } from "../../net/snapshot";
import type { Body, Cell } from "../cell";
import type { Camera } from "../camera";
import { Strokes } from "../overlays/strokes";
import { pick, rayAt } from "./pick";

/** At most 30 commands a second while the hand moves. */
const SEND_MS = 34;
/** So often while it rests: the spring lets go by itself after `PULL_S`. */
const HOLD_MS = 200;
const PULL_S = 0.3;
const WHEEL_M = 0.0002;
const FARTHEST_M = 5;
const LINE = 0x4cc9ff;

interface Pull {
  body: Body;
  pointer: number;
  plane: Plane;
  /** From the grabbed point to the body's own origin. */
  offset: Vector3;
  lift: number;
  to: Vector3;
  sentAt: number;
  moved: boolean;
}

export class Drag {
  readonly root = new Group();
  private pull: Pull | null = null;
  private timer = 0;
  private readonly line = new Strokes(1, LINE);
  private readonly hook: Mesh;

  constructor(
    private readonly element: HTMLElement,
    private readonly camera: Camera,
    private readonly store: Store,
    private readonly cell: () => Cell | null,
    private readonly changed: () => void,
  ) {
    const paint = new MeshBasicMaterial({ color: LINE, depthTest: false, transparent: true });
    this.hook = new Mesh(new SphereGeometry(0.008, 12, 8), paint);
    this.hook.renderOrder = 10;
    this.hook.raycast = () => {};
    this.root.add(this.line.lines, this.hook);
    this.root.visible = false;
    // On the way down to the canvas, before the camera's own handlers.
    const early = { capture: true };
    element.addEventListener("pointerdown", (event) => this.grab(event), early);
    element.addEventListener("pointermove", (event) => this.move(event), early);
    element.addEventListener("pointerup", (event) => this.release(event), early);
    element.addEventListener("pointercancel", (event) => this.release(event), early);
    element.addEventListener("wheel", (event) => this.wheel(event), { capture: true, passive: false });
    window.addEventListener("blur", () => this.drop());
    window.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.drop();
    });
  }

  get active(): boolean {
    return this.pull !== null;
  }

  /** Lets go. */
  drop(): void {
    if (this.pull === null) return;
    clearInterval(this.timer);
    if (this.element.hasPointerCapture(this.pull.pointer)) {
      this.element.releasePointerCapture(this.pull.pointer);
    }
    this.pull = null;
    this.root.visible = false;
    this.changed();
  }

  /** Draws the line from the body to where it is pulled. */
  update(): void {
    if (this.pull === null) return;
    this.line.clear();
    this.line.add(this.pull.body.group.position, this.pull.to);
    this.hook.position.copy(this.pull.to);
  }

  private grab(event: PointerEvent): void {
    const cell = this.cell();
    if (!event.shiftKey || event.button !== 0 || cell === null || this.pull !== null) return;
    rayAt(event.clientX, event.clientY, this.element, this.camera.lens);
    // A cube that a hand holds, or hides, can be pulled as well.
    const hit = pick(cell, true);
    if (hit?.body == null) return;
    event.stopPropagation();
    event.preventDefault();
    const refusal = this.refusal();
    if (refusal !== null) {
      this.store.emit("notice", { text: refusal, bad: true });
      return;
    }
    const facing = this.camera.lens.getWorldDirection(new Vector3()).negate();
    this.pull = {
      body: hit.body,
      pointer: event.pointerId,
      plane: new Plane().setFromNormalAndCoplanarPoint(facing, hit.point),
      offset: hit.body.group.position.clone().sub(hit.point),
      lift: 0,
      to: hit.body.group.position.clone(),
      sentAt: 0,
      moved: false,
    };
    this.element.setPointerCapture(event.pointerId);
    this.root.visible = true;
    this.timer = window.setInterval(() => this.send(), SEND_MS);
    this.changed();
  }

  private refusal(): string | null {
    if (this.store.hello?.role === "viewer") return "a viewer can look, not touch";
    const flags = this.store.snapshot?.flags ?? 0;
    return (flags & FLAG.notLive) !== 0 ? "the past cannot be touched: go back to live" : null;
  }

  private move(event: PointerEvent): void {
    const { pull } = this;
    if (pull === null || event.pointerId !== pull.pointer) return;
    event.stopPropagation();
    const ray = rayAt(event.clientX, event.clientY, this.element, this.camera.lens);
    const hit = ray.intersectPlane(pull.plane, new Vector3());
    if (hit === null) return;
    hit.add(pull.offset);
    hit.z += pull.lift;
    // With Ctrl the hand moves straight up and down.
    if (event.ctrlKey) hit.set(pull.to.x, pull.to.y, hit.z);
    pull.to.copy(hit).clampScalar(-FARTHEST_M, FARTHEST_M);
    pull.moved = true;
    this.changed();
  }

  private wheel(event: WheelEvent): void {
    if (this.pull === null) return;
    event.stopPropagation();
    event.preventDefault();
    const step = -event.deltaY * WHEEL_M;
    this.pull.lift += step;
    this.pull.to.z += step;
    this.pull.moved = true;
    this.changed();
  }

  private release(event: PointerEvent): void {
    if (event.pointerId !== this.pull?.pointer) return;
    event.stopPropagation();
    this.send();
    this.drop();
  }

  private send(): void {
    const { pull } = this;
    if (pull === null) return;
    const now = performance.now();
    const rested = now - pull.sentAt;
    if (rested < (pull.moved ? SEND_MS - 2 : HOLD_MS)) return;
    pull.sentAt = now;
    pull.moved = false;
    const to = pull.to.toArray() as Vec3;
    void this.store.command({ do: "drag", object: pull.body.name, to, for_s: PULL_S }).then((ack) => {
      // One refusal is enough: those after it would say the same.
      if (!ack.ok && this.pull === pull) this.drop();
    });
  }
}
