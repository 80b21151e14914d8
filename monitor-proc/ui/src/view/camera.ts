// Where the cell is seen from: presets, the mouse, the URL's hash.
import { Box3, PerspectiveCamera, Sphere, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Scene } from "../net/protocol";
import { getHash, setHash } from "../panels/hash";

const FIELD_OF_VIEW = 38;
const SETTLE_MS = 300;
const TOOL_OFFSET = new Vector3(0.5, -0.28, 0.3);
const FOCUS_DISTANCE_M = 0.9;
/** Directions from the cell to the eye. */
const TOP = new Vector3(-0.001, 0, 1);
const FRONT = new Vector3(1, 0, 0.22);
const SIDE = new Vector3(0.001, -1, 0.22);

export class Camera {
  readonly lens = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.02, 80);
  readonly orbit: OrbitControls;
  /** What the camera goes along with, as of the last frame. */
  private followed: Vector3 | null = null;
  private following = false;
  private extent = new Sphere(new Vector3(0.3, 0, 0.3), 0.9);
  private seen = { eye: new Vector3(1.5, 0.5, 1.2), target: new Vector3(0.5, 0, 0.2) };
  private writing = 0;

  constructor(
    element: HTMLElement,
    private readonly changed: () => void,
  ) {
    this.orbit = new OrbitControls(this.lens, element);
    this.orbit.zoomToCursor = true;
    this.orbit.minDistance = 0.1;
    this.orbit.maxDistance = 12;
    this.orbit.maxPolarAngle = 0.56 * Math.PI;
    this.orbit.addEventListener("change", this.changed);
    this.orbit.addEventListener("end", () => this.write());
    this.look(this.seen.target, this.seen.eye);
  }

  /** Takes over a new scene; `extent` holds all that should be in the picture. */
  frame(scene: Scene, extent: Box3): void {
    extent.getBoundingSphere(this.extent);
    this.seen.eye.set(...scene.camera.eye_m);
    this.seen.target.set(...scene.camera.target_m);
    if (!this.restore()) this.preset(1, null);
  }

  /** 1 the scene's own, 2 from above, 3 front, 4 side, 5 at the tool. */
  preset(number: number, tool: Vector3 | null): void {
    this.following = number === 5 && tool !== null;
    this.followed = null;
    const { center } = this.extent;
    if (number === 5 && tool !== null) {
      this.look(tool, tool.clone().add(TOOL_OFFSET));
      this.followed = tool.clone();
    } else if (number === 2) this.fit(center, TOP);
    else if (number === 3) this.fit(center, FRONT);
    else if (number === 4) this.fit(center, SIDE);
    else {
      const direction = this.seen.eye.clone().sub(this.seen.target);
      // The whole cell is shown, also where the panels leave little room.
      const middle = this.seen.target.clone().lerp(center, 0.5);
      this.fit(middle, direction);
    }
    if (number === 1) setHash("cam", null);
    else this.write();
  }

  /** Goes along with the tool while preset 5 is on; true where it moved. */
  follow(tool: Vector3 | null): void {
    if (!this.following || tool === null) return;
    if (this.followed !== null) {
      const step = tool.clone().sub(this.followed);
      this.lens.position.add(step);
      this.orbit.target.add(step);
      this.orbit.update();
    }
    this.followed = tool.clone();
  }

  /** Brings a point to the middle, from the side it is seen from now. */
  focus(point: Vector3): void {
    this.following = false;
    const direction = this.lens.position.clone().sub(this.orbit.target).normalize();
    this.look(point, point.clone().addScaledVector(direction, FOCUS_DISTANCE_M));
    this.write();
  }

  resize(width: number, height: number): void {
    this.lens.aspect = width / height;
    this.lens.updateProjectionMatrix();
    if (getHash("cam") === null && !this.following) this.preset(1, null);
  }

  private fit(target: Vector3, direction: Vector3): void {
    const half = (this.lens.fov * Math.PI) / 360;
    const across = Math.atan(Math.tan(half) * this.lens.aspect);
    const away = this.extent.radius / Math.sin(Math.min(half, across));
    const unit = direction.clone().normalize();
    this.look(target, target.clone().addScaledVector(unit, away));
  }

  private look(target: Vector3, eye: Vector3): void {
    this.lens.position.copy(eye);
    this.orbit.target.copy(target);
    this.orbit.update();
    this.changed();
  }

  private restore(): boolean {
    const numbers = (getHash("cam") ?? "").split(",").map(Number);
    if (numbers.length !== 6 || !numbers.every(Number.isFinite)) return false;
    const [a = 0, b = 0, c = 0, d = 0, e = 0, f = 0] = numbers;
    this.look(new Vector3(d, e, f), new Vector3(a, b, c));
    return true;
  }

  /** Writes the hash once the hand rests: browsers limit how often it may change. */
  private write(): void {
    clearTimeout(this.writing);
    this.writing = window.setTimeout(() => {
      const numbers = [...this.lens.position.toArray(), ...this.orbit.target.toArray()];
      setHash("cam", numbers.map((number) => number.toFixed(3)).join(","));
    }, SETTLE_MS);
  }
}
