// Where the cell is seen from: presets, the mouse, the URL's hash (`#view=top`, or
// `#cam=...` once it was turned).
import { Box3, OrthographicCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Scene } from "../net/protocol";
import { getHash, setHash } from "../panels/hash";
import { halfHeight, type Lens, orthographic, perspective } from "./lens";

const SETTLE_MS = 300;
const TOOL_OFFSET = new Vector3(0.5, -0.28, 0.3);
const FOCUS_DISTANCE_M = 0.9;
/** Directions from the cell to the eye. */
const TOP = new Vector3(-0.001, 0, 1);
const FRONT = new Vector3(1, 0, 0);
const SIDE = new Vector3(0, -1, 0);
/** Of the orthographic views, by the number of the preset. */
const ORTHO: Record<number, Vector3> = { 2: TOP, 3: FRONT, 4: SIDE };

/** Names of the presets in the address; where none is named it is the cell's own. */
const NAMED: Record<string, number> = { cell: 1, top: 2, front: 3, side: 4 };

const NEAREST_M = 0.1;
const FARTHEST_M = 12;
const STEEPEST_RAD = 1e-3;

/** A narrower picture has no room for the whole table: its objects would be some pixels wide. */
const NARROW_PX = 480;
/** A target that moved farther is another one: the picture need not hold the last one. */
const ELSEWHERE_M = 0.2;

const FIT_ROUNDS = 4;
/** Of the picture's half width and height. */
const FIT_MARGIN = 0.95;

/** What panels cover of the picture's borders (CSS pixels). */
export interface Covered {
  left: number;
  top: number;
}

/** A point's offset across the picture, and towards the eye. */
interface Side {
  at: number;
  depth: number;
}

export class Camera {
  /** The lens in use. */
  lens: Lens;
  readonly orbit: OrbitControls;
  private readonly free = perspective();
  private readonly ortho = orthographic();
  /** Width and height of the picture (CSS pixels). */
  private size: [number, number] = [1, 1];
  private covered: Covered = { left: 0, top: 0 };
  /** What the camera goes along with, as of the last frame. */
  private followed: Vector3 | null = null;
  private following = false;
  /** A target outside of the cell, with its handles. */
  private added: Vector3[] = [];
  /** A person turned the camera, and no preset was chosen since. */
  private turned = false;
  private points = [new Vector3(-0.3, -0.5, 0), new Vector3(0.7, 0.5, 0.8)];
  private work: Vector3[] = [];
  private seen = { eye: new Vector3(1.5, 0.5, 1.2), target: new Vector3(0.5, 0, 0.2) };
  private writing = 0;
  private before = "";

  constructor(
    element: HTMLElement,
    private readonly changed: () => void,
  ) {
    this.lens = this.free;
    this.orbit = new OrbitControls(this.lens, element);
    this.orbit.zoomToCursor = true;
    this.orbit.minDistance = NEAREST_M;
    this.orbit.maxDistance = FARTHEST_M;
    this.orbit.maxPolarAngle = 0.56 * Math.PI;
    // Straight down, the address would not say which side is up.
    this.orbit.minPolarAngle = STEEPEST_RAD;
    this.orbit.addEventListener("change", this.changed);
    this.orbit.addEventListener("start", () => {
      this.before = this.numbers();
      this.turned = true;
    });
    this.orbit.addEventListener("end", () => {
      // A click that turns nothing leaves the address alone.
      if (this.numbers() !== this.before) this.write();
      else this.turned = getHash("cam") !== null;
    });
    this.look(this.seen.target, this.seen.eye);
    addEventListener("hashchange", () => {
      this.following = false;
      this.turned = getHash("cam") !== null;
      this.restore();
    });
  }

  /** Another scene: what the address says was meant for the last one. */
  forget(): void {
    this.added = [];
    this.preset(1, null);
  }

  /** Takes over a new scene; `points` should all be in the picture, in a narrow one `work` alone. */
  frame(scene: Scene, points: Vector3[], work: Vector3[]): void {
    this.points = points;
    this.work = work;
    this.seen.eye.set(...scene.camera.eye_m);
    this.seen.target.set(...scene.camera.target_m);
    this.restore();
  }

  /**
   * Has `points` in the picture as well, where a person did not turn the camera. Whether it moved:
   * handles keep their size in the picture, so that they are elsewhere in the world then.
   */
  include(points: Vector3[]): boolean {
    if (this.turned || this.following || getHash("cam") !== null || points.length === 0) return false;
    const middle = (all: Vector3[]) => new Box3().setFromPoints(all).getCenter(new Vector3());
    if (this.added.length > 0 && middle(this.added).distanceTo(middle(points)) > ELSEWHERE_M) {
      this.added = [];
      this.reframe();
    }
    this.lens.updateMatrixWorld();
    if (points.every((point) => this.shows(point))) return false;
    this.added = points;
    this.reframe();
    this.lens.updateMatrixWorld();
    return true;
  }

  /** Whether a point is in the uncovered part of the picture. */
  private shows(point: Vector3): boolean {
    const [width, height] = this.size;
    const { left, top } = this.covered;
    const { x, y } = point.clone().project(this.lens);
    const [right, down] = [(0.5 + x / 2) * width, (0.5 - y / 2) * height];
    return right >= left && right <= width && down >= top && down <= height;
  }

  private get framed(): Vector3[] {
    const isNarrow = this.size[0] - this.covered.left < NARROW_PX && this.work.length > 0;
    return [...(isNarrow ? this.work : this.points), ...this.added];
  }

  /** 1 the cell's own, 2 from above, 3 front, 4 side, 5 at the tool. */
  preset(number: number, tool: Vector3 | null): void {
    this.following = number === 5 && tool !== null;
    this.followed = null;
    this.turned = false;
    if (number === 5 && tool !== null) {
      this.use(this.free);
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
    const ortho = ORTHO[number];
    this.use(ortho === undefined ? this.free : this.ortho);
    if (ortho !== undefined) this.fitOrtho(ortho);
    // The whole cell is shown, also where the panels leave little room.
    else this.fit(this.seen.eye.clone().sub(this.seen.target));
  }

  private use(lens: Lens): void {
    if (lens === this.lens) return;
    this.lens = lens;
    this.orbit.object = lens;
    this.resizeLens();
  }

  private resizeLens(): void {
    const [width, height] = this.size;
    const { left, top } = this.covered;
    this.free.aspect = width / height;
    this.ortho.left = (this.ortho.bottom * width) / height;
    this.ortho.right = (this.ortho.top * width) / height;
    // The orbit's target is in the middle of the uncovered part.
    this.lens.setViewOffset(width, height, -left / 2, -top / 2, width, height);
  }

  /** Width and height of the uncovered part, as shares of the height of the picture. */
  private get clear(): [number, number] {
    const [width, height] = this.size;
    const { left, top } = this.covered;
    return [Math.max(1, width - left) / height, Math.max(1, height - top) / height];
  }

  /** Width of a pixel where the camera looks at (m). */
  get pixel_m(): number {
    const [, height] = this.size;
    if (this.lens === this.ortho) return (2 * this.ortho.top) / this.ortho.zoom / height;
    return (2 * halfHeight(this.lens.position.distanceTo(this.orbit.target))) / height;
  }

  /** Goes along with the tool while preset 5 is on, but not while something is dragged (`busy`): it would leave the pointer. */
  follow(tool: Vector3 | null, busy: boolean): void {
    if (!this.following || tool === null) return;
    if (busy) return;
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
    this.turned = true;
    const direction = this.lens.position.clone().sub(this.orbit.target);
    // An orthographic view is enlarged instead: a camera that near would be inside of the objects.
    const isOrtho = this.lens === this.ortho;
    if (!isOrtho) direction.setLength(FOCUS_DISTANCE_M);
    this.look(point, point.clone().add(direction));
    if (isOrtho) this.height(halfHeight(FOCUS_DISTANCE_M));
    this.write();
  }

  resize(width: number, height: number): void {
    this.size = [width, height];
    // What had no room in another picture may have it in this one.
    this.added = [];
    this.reframe();
  }

  /** Frames the cell beside what covers the picture. */
  cover(covered: Covered): void {
    if (covered.left === this.covered.left && covered.top === this.covered.top) return;
    this.covered = covered;
    this.added = [];
    this.reframe();
    this.changed();
  }

  private reframe(): void {
    this.resizeLens();
    if (getHash("cam") === null && !this.following) this.restore();
  }

  /** The points to be framed from `direction`, the axes of the picture, and the middle of their box. */
  private sight(direction: Vector3) {
    const points = this.framed;
    const back = direction.clone().normalize();
    const right = new Vector3(0, 0, 1).cross(back).normalize();
    const target = new Box3().setFromPoints(points).getCenter(new Vector3());
    return { points, back, right, up: back.clone().cross(right), target };
  }

  /** Moves back along `direction` until the whole cell is in the picture. */
  private fit(direction: Vector3): void {
    const { points, back, right, up, target } = this.sight(direction);
    const tan = halfHeight(1);
    const [across, upright] = this.clear;
    let away = 1;
    for (let round = 0; round < FIT_ROUNDS; round++) {
      const corners = points.map((point) => point.clone().sub(target));
      const [wide, tall] = [right, up].map((axis, index) => {
        const reach = tan * (index === 0 ? across : upright) * FIT_MARGIN;
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
      target.addScaledVector(right, skew(wide) * step * across);
      target.addScaledVector(up, skew(tall) * step * upright);
    }
    this.look(target, target.clone().addScaledVector(back, away));
  }

  /** The whole cell without perspective, so that alignment of objects can be read off. */
  private fitOrtho(direction: Vector3): void {
    const { points, back, right, up, target } = this.sight(direction);
    const extent = (axis: Vector3) => {
      const all = points.map((point) => point.clone().sub(target).dot(axis));
      return [Math.min(...all), Math.max(...all)] as const;
    };
    const [wide, tall, depth] = [extent(right), extent(up), extent(back)];
    target.addScaledVector(right, (wide[0] + wide[1]) / 2).addScaledVector(up, (tall[0] + tall[1]) / 2);
    const [across, upright] = this.clear;
    const half = Math.max((tall[1] - tall[0]) / 2 / upright, (wide[1] - wide[0]) / 2 / across) / FIT_MARGIN;
    this.look(target, target.clone().addScaledVector(back, depth[1] + half / halfHeight(1)));
    this.height(half);
  }

  /** Half the height of a orthographic picture (m). */
  private height(half_m: number): void {
    [this.ortho.top, this.ortho.bottom, this.ortho.zoom] = [half_m, -half_m, 1];
    this.orbit.minZoom = half_m / halfHeight(FARTHEST_M);
    this.orbit.maxZoom = half_m / halfHeight(NEAREST_M);
    this.resizeLens();
    this.orbit.update();
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
    const isWhole = [6, 7].includes(numbers.length) && numbers.every(Number.isFinite);
    if (!isWhole || (numbers[6] ?? 1) <= 0) {
      this.fitPreset(NAMED[getHash("view") ?? ""] ?? 1);
      return;
    }
    const [a = 0, b = 0, c = 0, d = 0, e = 0, f = 0, half] = numbers;
    this.use(half === undefined ? this.free : this.ortho);
    this.look(new Vector3(d, e, f), new Vector3(a, b, c));
    if (half !== undefined) this.height(half);
  }

  /** Writes the hash once the view rests: browsers limit how often it may change. */
  private write(): void {
    clearTimeout(this.writing);
    this.writing = window.setTimeout(() => {
      setHash("cam", this.numbers());
      setHash("view", null);
    }, SETTLE_MS);
  }

  private numbers(): string {
    const numbers = [...this.lens.position.toArray(), ...this.orbit.target.toArray()];
    // An orthographic view has a seventh number: half the height of the picture (m).
    if (this.lens instanceof OrthographicCamera) numbers.push(this.ortho.top / this.ortho.zoom);
    return numbers.map((number) => number.toFixed(5)).join(",");
  }
}
