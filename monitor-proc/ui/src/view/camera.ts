// Where the cell is seen from: presets, the mouse, the URL's hash (`#view=top`, or
// `#cam=...` once a hand turned it).
import { Box3, PerspectiveCamera, Vector3 } from "three";
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

/** Names of the presets in the address; where none is named it is the cell's own. */
const NAMED: Record<string, number> = { cell: 1, top: 2, front: 3, side: 4 };

const FIT_ROUNDS = 4;
/** Of the picture's half width and height. */
const FIT_MARGIN = 0.95;

/** A point's offset across the picture, and towards the eye. */
interface Side {
  at: number;
  depth: number;
}

export class Camera {
  readonly lens = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.04, 80);
  readonly orbit: OrbitControls;
  /** What the camera goes along with, as of the last frame. */
  private followed: Vector3 | null = null;
  private following = false;
  private points = [new Vector3(-0.3, -0.5, 0), new Vector3(0.7, 0.5, 0.8)];
  private seen = { eye: new Vector3(1.5, 0.5, 1.2), target: new Vector3(0.5, 0, 0.2) };
  private writing = 0;
  private before = "";

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
    this.orbit.addEventListener("start", () => {
      this.before = this.numbers();
    });
    this.orbit.addEventListener("end", () => {
      // A click that turns nothing leaves the address alone.
      if (this.numbers() !== this.before) this.write();
    });
    this.look(this.seen.target, this.seen.eye);
    addEventListener("hashchange", () => this.restore());
  }

  /** Another scene: what the address says was meant for the last one. */
  forget(): void {
    this.preset(1, null);
  }

  /** Takes over a new scene; `points` should all be in the picture. */
  frame(scene: Scene, points: Vector3[]): void {
    this.points = points;
    this.seen.eye.set(...scene.camera.eye_m);
    this.seen.target.set(...scene.camera.target_m);
    this.restore();
  }

  /** 1 the cell's own, 2 from above, 3 front, 4 side, 5 at the tool. */
  preset(number: number, tool: Vector3 | null): void {
    this.following = number === 5 && tool !== null;
    this.followed = null;
    if (number === 5 && tool !== null) {
      this.look(tool, tool.clone().add(TOOL_OFFSET));
      this.followed = tool.clone();
      this.write();
      return;
    }
    this.fitPreset(number);
    clearTimeout(this.writing);
    const name = Object.keys(NAMED).find((name) => NAMED[name] === number) ?? "cell";
    setHash("cam", null);
    setHash("view", name === "cell" ? null : name);
  }

  private fitPreset(number: number): void {
    if (number === 2) this.fit(TOP);
    else if (number === 3) this.fit(FRONT);
    else if (number === 4) this.fit(SIDE);
    // The whole cell is shown, also where the panels leave little room.
    else this.fit(this.seen.eye.clone().sub(this.seen.target));
  }

  /** Goes along with the tool while preset 5 is on. */
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
    if (getHash("cam") === null && !this.following) this.restore();
  }

  /** Stands back along `direction` until the whole cell is in the picture. */
  private fit(direction: Vector3): void {
    const back = direction.clone().normalize();
    const right = new Vector3(0, 0, 1).cross(back).normalize();
    const up = back.clone().cross(right);
    const tan = Math.tan((this.lens.fov * Math.PI) / 360);
    const target = new Box3().setFromPoints(this.points).getCenter(new Vector3());
    let away = 1;
    for (let round = 0; round < FIT_ROUNDS; round++) {
      const corners = this.points.map((point) => point.clone().sub(target));
      const [wide, tall] = [right, up].map((axis, index) => {
        const reach = tan * (index === 0 ? this.lens.aspect : 1) * FIT_MARGIN;
        return corners.map((corner) => ({ at: corner.dot(axis) / reach, depth: corner.dot(back) }));
      }) as [Side[], Side[]];
      const needed = (sides: Side[]) => Math.max(...sides.map(({ at, depth }) => Math.abs(at) + depth));
      away = Math.max(needed(wide), needed(tall));
      // Near corners look larger: the middle of the picture is not that of the box.
      const skew = (sides: Side[]) => {
        const seen = sides.map(({ at, depth }) => at / (away - depth));
        return (Math.max(...seen) + Math.min(...seen)) / 2;
      };
      const step = away * tan * FIT_MARGIN;
      target.addScaledVector(right, skew(wide) * step * this.lens.aspect);
      target.addScaledVector(up, skew(tall) * step);
    }
    this.look(target, target.clone().addScaledVector(back, away));
  }

  private look(target: Vector3, eye: Vector3): void {
    this.lens.position.copy(eye);
    this.orbit.target.copy(target);
    this.orbit.update();
    this.changed();
  }

  /** Looks from where the address says. */
  private restore(): void {
    const numbers = (getHash("cam") ?? "").split(",").map(Number);
    if (numbers.length !== 6 || !numbers.every(Number.isFinite)) {
      this.fitPreset(NAMED[getHash("view") ?? ""] ?? 1);
      return;
    }
    const [a = 0, b = 0, c = 0, d = 0, e = 0, f = 0] = numbers;
    this.look(new Vector3(d, e, f), new Vector3(a, b, c));
  }

  /** Writes the hash once the hand rests: browsers limit how often it may change. */
  private write(): void {
    clearTimeout(this.writing);
    this.writing = window.setTimeout(() => {
      setHash("cam", this.numbers());
      setHash("view", null);
    }, SETTLE_MS);
  }

  private numbers(): string {
    const numbers = [...this.lens.position.toArray(), ...this.orbit.target.toArray()];
    return numbers.map((number) => number.toFixed(3)).join(",");
  }
}
