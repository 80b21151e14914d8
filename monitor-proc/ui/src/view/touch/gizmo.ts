// The handle that moves and turns an arm's target. It leads the arm while the
// task is paused, and goes along with the tool while it is not.
import { Object3D, OrthographicCamera, Quaternion, Vector3 } from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import { poseOf } from "../../hand/aims";
import type { Frame, Hand } from "../../hand/hand";
import type { Pose } from "../../net/protocol";
import type { Snapshot } from "../../net/snapshot";
import type { Camera } from "../camera";
import type { Area } from "../labels";
import { halfHeight } from "../lens";

/** Share of a drag with Shift. */
const FINE = 0.1;
const LIVE_SIZE = 0.85;
const IDLE_SIZE = 0.4;
/** Of an arrow's length in the units of the handle: where it is easy to hit. */
const GRIP = 0.4;
/** From the middle of the handle to the tip of an arrow, in the same units. */
const TIP = 0.62;

/** Around the middle of a handle that cannot lead. */
const NEAR_PX = 24;

/** What a drag of the handle `axis` does. */
function leads(axis: string, mode: string, frame: Frame): string {
  const names = axis.replace(/E$/, "").toLowerCase();
  if (mode === "rotate") {
    if (names.length === 1) return `Drag turns the tool about ${names} of the ${frame}; Shift: fine; T: move it`;
    return `Drag turns the tool ${axis === "E" ? "about the line of sight" : "freely"}; Shift: fine; T: move it`;
  }
  const of = `of the ${frame}`;
  const direction =
    { 1: `along ${names} ${of}`, 2: `in the plane ${names} ${of}` }[names.length] ?? "in the plane of the picture";
  return `Drag leads the tool ${direction}; Shift: fine; E: turn it`;
}

const AXES: Record<string, Vector3 | undefined> = {
  x: new Vector3(1, 0, 0),
  y: new Vector3(0, 1, 0),
  z: new Vector3(0, 0, 1),
};

/** Shift makes the rest of a drag fine: what was dragged before stays. */
interface Anchor {
  fine: boolean;
  raw: { at: Vector3; turn: Quaternion };
  kept: { at: Vector3; turn: Quaternion };
}

export class Gizmo {
  readonly root: Object3D;
  /** The arm that is led; its place in the scene. */
  arm = 0;
  /** Whether the operator can lead the arm now. */
  live = false;
  private readonly goal = new Object3D();
  private readonly controls: TransformControls;
  private shift = false;
  private anchor: Anchor | null = null;

  constructor(
    canvas: HTMLElement,
    private readonly camera: Camera,
    private readonly hand: Hand,
    changed: () => void,
  ) {
    this.controls = new TransformControls(camera.lens, canvas);
    this.controls.attach(this.goal);
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("objectChange", () => this.moved());
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      camera.orbit.enabled = value !== true;
      this.anchor = null;
      if (value === true) this.hand.begin();
    });
    for (const kind of ["pointermove", "pointerdown"] as const) {
      canvas.addEventListener(kind, ({ shiftKey }) => (this.shift = shiftKey), { capture: true });
    }
    this.root = new Object3D();
    this.root.add(this.goal, this.controls.getHelper());
    this.root.visible = false;
    // three.js computes its handles again for each picture, also while they are not drawn.
    const update = this.root.updateMatrixWorld.bind(this.root);
    this.root.updateMatrixWorld = (force) => {
      if (this.root.visible) update(force);
    };
  }

  get dragging(): boolean {
    return this.controls.dragging;
  }

  /** Whether a press would take a handle. */
  get pointed(): boolean {
    return this.live && this.root.visible && this.controls.axis !== null;
  }

  /** Whether its handles turn the tool. */
  get turns(): boolean {
    return this.controls.mode === "rotate";
  }

  mode(mode: "translate" | "rotate"): void {
    this.controls.setMode(mode);
  }

  /** `shown`: also while it cannot lead. */
  update(snapshot: Snapshot, shown: boolean): void {
    const isHere = snapshot.arms[this.arm] !== undefined;
    this.live = isHere && this.hand.refusal() === null;
    this.present();
    this.controls.camera = this.camera.lens;
    this.controls.setSpace(this.hand.frame === "tool" ? "local" : "world");
    this.root.visible = isHere && (this.live || shown);
    if (this.dragging) return;
    const pose = this.hand.pose(this.arm);
    if (pose !== null) this.put(pose);
  }

  /** Where a handle is (`x`, `y`, `z`, or the middle), in the world (m). */
  handle(axis: string | null): Vector3 {
    this.goal.updateWorldMatrix(true, false);
    const at = new Vector3().setFromMatrixPosition(this.goal.matrixWorld);
    const direction = axis === null ? undefined : AXES[axis];
    if (direction === undefined) return at;
    return at.addScaledVector(direction, GRIP * this.controls.size * this.unit(at));
  }

  /** The tips of its arrows in the world (m); none while it is not shown. */
  tips(): Vector3[] {
    if (!this.root.visible) return [];
    const at = this.handle(null);
    const length = TIP * this.controls.size * this.unit(at);
    const turn = this.controls.space === "local" ? this.goal.quaternion : new Quaternion();
    return Object.values(AXES).flatMap((axis = new Vector3()) =>
      [length, -length].map((along) => at.clone().addScaledVector(axis.clone().applyQuaternion(turn), along)),
    );
  }

  /** What its arrows cover of a picture (pixels). */
  area(width: number, height: number): Area | null {
    const tips = this.tips().map((tip) => tip.project(this.camera.lens));
    if (tips.length === 0) return null;
    const [xs, ys] = [tips.map(({ x }) => (0.5 + x / 2) * width), tips.map(({ y }) => (0.5 - y / 2) * height)];
    return { left: Math.min(...xs), right: Math.max(...xs), top: Math.min(...ys), bottom: Math.max(...ys) };
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
    if (this.live) return axis === null ? null : leads(axis, mode, this.hand.frame);
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

  private moved(): void {
    const raw = { at: this.goal.position.clone(), turn: this.goal.quaternion.clone() };
    const kept = this.anchor === null ? raw : this.scaled(this.anchor, raw);
    if (this.anchor?.fine !== this.shift) this.anchor = { fine: this.shift, raw, kept };
    this.goal.position.copy(kept.at);
    this.goal.quaternion.copy(kept.turn);
    this.hand.move(this.arm, poseOf(kept.at, kept.turn));
  }

  private scaled({ fine, raw: from, kept }: Anchor, raw: Anchor["raw"]): Anchor["kept"] {
    const share = fine ? FINE : 1;
    const turned = raw.turn.clone().multiply(from.turn.clone().invert());
    return {
      at: kept.at.clone().addScaledVector(raw.at.clone().sub(from.at), share),
      turn: new Quaternion().slerp(turned, share).multiply(kept.turn),
    };
  }
}
