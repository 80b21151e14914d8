// The handle that moves and turns an arm's target. It leads the arm while the
// task is paused, and goes along with the tool while it is not.
import { Object3D, OrthographicCamera, Vector3 } from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import type { Pose, Vec3 } from "../../net/protocol";
import { FLAG, type Snapshot } from "../../net/snapshot";
import type { Store } from "../../net/store";
import type { Camera } from "../camera";
import type { Cell } from "../cell";
import { halfHeight } from "../lens";

const SEND_MS = 50;
/** The monitor needs a moment to tell the target that was just sent. */
const ECHO_MS = 500;
const LIVE_SIZE = 0.85;
const IDLE_SIZE = 0.4;
/** Of an arrow's length in the units of the handle: where it is easy to hit. */
const GRIP = 0.4;

/** Around the middle of a handle that cannot lead. */
const NEAR_PX = 24;

/** What a drag of the handle `axis` does. */
function leads(axis: string, mode: string): string {
  const names = axis.replace(/E$/, "").toLowerCase();
  if (mode === "rotate") {
    if (names.length === 1) return `Drag turns the tool about its ${names} axis; T: move it`;
    return `Drag turns the tool ${axis === "E" ? "about the line of sight" : "freely"}; T: move it`;
  }
  const direction = { 1: `along ${names}`, 2: `in the plane ${names}` }[names.length] ?? "in the plane of the picture";
  return `Drag leads the tool ${direction}; E: turn it`;
}

const AXES: Record<string, Vector3 | undefined> = {
  x: new Vector3(1, 0, 0),
  y: new Vector3(0, 1, 0),
  z: new Vector3(0, 0, 1),
};

export class Gizmo {
  readonly root: Object3D;
  /** The arm that is led; its place in the scene. */
  arm = 0;
  /** Whether the operator can lead the arm now. */
  live = false;
  private readonly goal = new Object3D();
  private readonly controls: TransformControls;
  private sentAt = -Infinity;
  private timer = 0;
  /** The target as it was when the task was paused; the arm need not be near it. */
  private old: string | null = null;

  constructor(
    canvas: HTMLElement,
    private readonly camera: Camera,
    private readonly store: Store,
    private readonly changed: () => void,
  ) {
    this.controls = new TransformControls(camera.lens, canvas);
    this.controls.attach(this.goal);
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("objectChange", () => this.send());
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      camera.orbit.enabled = value !== true;
    });
    this.root = new Object3D();
    this.root.add(this.goal, this.controls.getHelper());
    this.root.visible = false;
  }

  get dragging(): boolean {
    return this.controls.dragging;
  }

  mode(mode: "translate" | "rotate"): void {
    this.controls.setMode(mode);
    // The tool turns about its own axes, and moves along the room's.
    this.controls.setSpace(mode === "rotate" ? "local" : "world");
  }

  /** `shown`: also while it cannot lead. */
  update(cell: Cell, snapshot: Snapshot, shown: boolean): void {
    const state = snapshot.arms[this.arm];
    const past = (snapshot.flags & FLAG.notLive) !== 0;
    const paused = (snapshot.flags & FLAG.taskPaused) !== 0 || cell.scene.task["kind"] === "reach";
    const viewer = this.store.hello?.role === "viewer";
    this.live = state !== undefined && paused && !past && !viewer;
    this.present();
    this.controls.camera = this.camera.lens;
    this.root.visible = state !== undefined && (this.live || shown);
    if (state === undefined) return;
    const target = state.targetValid ? JSON.stringify(state.target) : null;
    if (!this.live) this.old = null;
    else if (this.old === null) this.old = target ?? "";
    if (this.dragging || performance.now() - this.sentAt < ECHO_MS) return;
    const led = this.live && target !== null && target !== this.old;
    this.put(led ? state.target : state.tcp);
  }

  /** Where a handle is (`x`, `y`, `z`, or the middle), in the world (m). */
  handle(axis: string | null): Vector3 {
    this.goal.updateWorldMatrix(true, false);
    const at = new Vector3().setFromMatrixPosition(this.goal.matrixWorld);
    const direction = axis === null ? undefined : AXES[axis];
    if (direction === undefined) return at;
    return at.addScaledVector(direction, GRIP * this.controls.size * this.unit(at));
  }

  /** A quarter of the picture's height at a point, as the handle's size is counted (m). */
  private unit(at: Vector3): number {
    const { lens } = this.camera;
    if (lens instanceof OrthographicCamera) return (lens.top - lens.bottom) / lens.zoom / 4;
    return (at.distanceTo(lens.position) * 1.9 * halfHeight(1)) / 4;
  }

  /** What the mouse can do at this point of the view (pixels), where a handle is there. */
  hint(x: number, y: number, width: number, height: number): string | null {
    const { axis, mode } = this.controls;
    if (!this.root.visible) return null;
    if (this.live) return axis === null ? null : leads(axis, mode);
    const at = this.handle(null).project(this.camera.lens);
    const away = Math.hypot((0.5 + at.x / 2) * width - x, (0.5 - at.y / 2) * height - y);
    return away > NEAR_PX ? null : "Pause the task to lead the arm by this handle";
  }

  /** While it only goes along it is small and has arrows alone. */
  private present(): void {
    const { controls, live } = this;
    controls.enabled = live;
    controls.size = live ? LIVE_SIZE : IDLE_SIZE;
    controls.showXY = controls.showYZ = controls.showXZ = controls.showXYZE = live;
  }

  private put([x, y, z, qw, qx, qy, qz]: Pose): void {
    this.goal.position.set(x, y, z);
    this.goal.quaternion.set(qx, qy, qz, qw);
  }

  private send(): void {
    const wait = this.sentAt + SEND_MS - performance.now();
    clearTimeout(this.timer);
    if (wait > 0) {
      this.timer = window.setTimeout(() => this.send(), wait);
      return;
    }
    this.sentAt = performance.now();
    // A target that was refused is not told again: the handle goes back.
    this.timer = window.setTimeout(this.changed, ECHO_MS + 1);
    const { x, y, z, w } = this.goal.quaternion;
    void this.store.command({
      do: "target",
      arm: this.arm,
      position: this.goal.position.toArray() as Vec3,
      orientation_wxyz: [w, x, y, z],
    });
  }
}
