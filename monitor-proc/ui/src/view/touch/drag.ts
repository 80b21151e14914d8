// Shift-drag, or a drag after a long press on a touch screen, pulls a body by a spring; the
// monitor asks physics for it.
import { Group, Mesh, MeshBasicMaterial, type Ray, SphereGeometry } from "three";
import type { Vec3 } from "../../net/protocol";
import { FLAG } from "../../net/snapshot";
import type { Store } from "../../net/store";
import type { Camera } from "../camera";
import type { Body, Cell } from "../cell";
import type { Labels } from "../labels";
import { DropLine } from "../overlays/drop-line";
import { Strokes } from "../overlays/strokes";
import { bodyNear, rayAt } from "./pick";
import { Pull } from "./pull";
import { Snap } from "./snap";

/** At most 30 commands a second while the pointer moves. */
const SEND_MS = 34;
/** So often while it rests: the spring lets go by itself after `PULL_S`. */
const HOLD_MS = 200;
const PULL_S = 0.3;
const WHEEL_M = 0.0002;
const LINE = 0x4cc9ff;
/** A finger that stays for so long grabs; one that moves farther meanwhile turns the camera. */
const LONG_PRESS_MS = 500;
const STILL_PX = 10;

interface Grab {
  body: Body;
  pointer: number;
  pull: Pull;
  ray: Ray;
  /** Height of the pointer on the page (pixels). */
  y: number;
  sentAt: number;
  moved: boolean;
  /** Something was said about this pull. */
  told: boolean;
}

export class Drag {
  readonly root = new Group();
  private grabbed: Grab | null = null;
  private timer = 0;
  /** A finger that grabbed, until it leaves the screen. */
  private finger: number | null = null;
  private press: { timer: number; x: number; y: number } | null = null;
  private readonly held = new Group();
  private readonly line = new Strokes(1, LINE);
  private readonly drop = new DropLine(LINE);
  private readonly snap: Snap;
  private readonly hook: Mesh;

  constructor(
    private readonly element: HTMLElement,
    private readonly camera: Camera,
    private readonly store: Store,
    private readonly cell: () => Cell | null,
    private readonly changed: () => void,
    /** A handle of the target has the pointer. */
    private readonly taken: () => boolean,
  ) {
    const paint = new MeshBasicMaterial({ color: LINE, depthTest: false, transparent: true });
    this.hook = new Mesh(new SphereGeometry(0.008, 12, 8), paint);
    this.hook.renderOrder = 10;
    this.hook.raycast = () => {};
    this.held.add(this.line.lines, this.hook, this.drop.root);
    this.held.visible = false;
    // A press on a handle of the target takes the handle, not the object behind it.
    this.snap = new Snap(element, camera, cell, () => this.active || this.taken(), changed);
    this.root.add(this.held, this.snap.root);
    this.listen();
  }

  get active(): boolean {
    return this.grabbed !== null;
  }

  /** Lets go. */
  release(): void {
    this.forgetPress();
    const { grabbed } = this;
    if (grabbed === null) return;
    clearInterval(this.timer);
    if (this.element.hasPointerCapture(grabbed.pointer)) {
      this.element.releasePointerCapture(grabbed.pointer);
    }
    this.grabbed = null;
    this.held.visible = false;
    this.changed();
  }

  /** Draws the line from the body to where it is pulled, and its height. */
  update(cell: Cell, labels: Labels): void {
    this.snap.update();
    if (this.grabbed === null) return;
    const { body, pull } = this.grabbed;
    this.line.clear();
    this.line.add(body.group.position, pull.to);
    this.hook.position.copy(pull.to);
    this.drop.below(cell, body, labels);
  }

  private listen(): void {
    const { element } = this;
    // On the way down to the canvas, before the camera's own handlers.
    const early = { capture: true };
    element.addEventListener("pointerdown", (event) => this.down(event), early);
    element.addEventListener("pointermove", (event) => this.move(event), early);
    element.addEventListener("pointerup", (event) => this.up(event), early);
    element.addEventListener("pointercancel", (event) => this.up(event), early);
    element.addEventListener("wheel", (event) => this.wheel(event), { capture: true, passive: false });
    // The menu of a long press would take the finger away.
    element.addEventListener("contextmenu", (event) => {
      if (this.press !== null || this.active) event.preventDefault();
    });
    window.addEventListener("blur", () => this.release());
    window.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.release();
    });
  }

  private down(event: PointerEvent): void {
    if (this.grabbed !== null || this.taken()) return;
    if (event.pointerType === "touch") this.startPress(event);
    else if (event.shiftKey && event.button === 0) {
      // Also beside every body: the camera would pan.
      event.stopPropagation();
      event.preventDefault();
      if (this.grab(event)) this.element.setPointerCapture(event.pointerId);
    }
  }

  private startPress(event: PointerEvent): void {
    this.forgetPress();
    if (!event.isPrimary) return;
    const { clientX: x, clientY: y } = event;
    const timer = window.setTimeout(() => {
      this.press = null;
      // The arrows of the target have the finger.
      if (!this.camera.orbit.enabled || !this.grab(event)) return;
      // The camera's own handlers have this pointer, too: they wait until it leaves.
      this.camera.orbit.enabled = false;
      this.finger = event.pointerId;
    }, LONG_PRESS_MS);
    this.press = { timer, x, y };
  }

  private forgetPress(): void {
    clearTimeout(this.press?.timer);
    this.press = null;
  }

  private grab({ clientX, clientY, pointerId }: PointerEvent): boolean {
    const cell = this.cell();
    if (cell === null) return false;
    const hit = bodyNear(clientX, clientY, this.element, this.camera.lens, cell);
    if (hit?.body == null) return false;
    const refusal = this.refusal();
    if (refusal !== null) {
      this.store.emit("notice", { text: refusal, bad: true });
      return false;
    }
    this.grabbed = {
      body: hit.body,
      pointer: pointerId,
      pull: new Pull(hit.body.group.position, hit.point, this.camera.lens),
      ray: this.rayOf(clientX, clientY),
      y: clientY,
      sentAt: 0,
      moved: false,
      told: false,
    };
    // The pointer may be beside the point that was grabbed.
    this.grabbed.pull.lift(0, this.grabbed.ray);
    this.held.visible = true;
    this.timer = window.setInterval(() => this.send(), SEND_MS);
    this.changed();
    return true;
  }

  private refusal(): string | null {
    if (this.store.hello?.role === "viewer") return "a viewer cannot move objects";
    const flags = this.store.snapshot?.flags ?? 0;
    return (flags & FLAG.notLive) !== 0 ? "an earlier time is shown: go back to live to move objects" : null;
  }

  private rayOf(x: number, y: number): Ray {
    return rayAt(x, y, this.element, this.camera.lens).clone();
  }

  private move(event: PointerEvent): void {
    const { press, grabbed } = this;
    if (press !== null && Math.hypot(event.clientX - press.x, event.clientY - press.y) > STILL_PX) this.forgetPress();
    if (grabbed === null || event.pointerId !== grabbed.pointer) return;
    event.stopPropagation();
    grabbed.ray = this.rayOf(event.clientX, event.clientY);
    if (event.ctrlKey) grabbed.pull.up(grabbed.ray, grabbed.y - event.clientY, this.element.clientHeight);
    else grabbed.pull.along(grabbed.ray);
    grabbed.y = event.clientY;
    grabbed.moved = true;
    this.changed();
  }

  private wheel(event: WheelEvent): void {
    const { grabbed } = this;
    if (grabbed === null) return;
    event.stopPropagation();
    event.preventDefault();
    // With Shift, some browsers turn the wheel's direction.
    const turned = event.deltaY === 0 ? event.deltaX : event.deltaY;
    grabbed.pull.lift(-turned * WHEEL_M, grabbed.ray);
    grabbed.moved = true;
    this.changed();
  }

  private up(event: PointerEvent): void {
    this.forgetPress();
    // Earlier, the view would turn by the whole way of the finger.
    if (event.pointerId === this.finger) {
      this.finger = null;
      this.camera.orbit.enabled = true;
    }
    if (event.pointerId !== this.grabbed?.pointer) return;
    // The camera's handlers have seen a finger come, and have to see it leave.
    if (event.pointerType !== "touch") event.stopPropagation();
    if (this.grabbed.moved) this.pullNow(this.grabbed);
    this.release();
  }

  private send(): void {
    const { grabbed } = this;
    if (grabbed === null) return;
    const rested = performance.now() - grabbed.sentAt;
    if (rested >= (grabbed.moved ? SEND_MS - 2 : HOLD_MS)) this.pullNow(grabbed);
  }

  private pullNow(grabbed: Grab): void {
    grabbed.sentAt = performance.now();
    grabbed.moved = false;
    const to = grabbed.pull.to.toArray() as Vec3;
    void this.store.command({ do: "drag", object: grabbed.body.name, to, for_s: PULL_S }).then((ack) => {
      // One refusal is enough: those after it would say the same.
      if (!ack.ok && this.grabbed === grabbed) this.release();
      if (!ack.ok || ack.message === "" || grabbed.told) return;
      grabbed.told = true;
      this.store.emit("notice", { text: `${grabbed.body.name}: ${ack.message}`, bad: true });
    });
  }
}
