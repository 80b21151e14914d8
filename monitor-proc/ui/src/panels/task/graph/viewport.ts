// Pan and zoom of a drawing: drag, wheel, pinch, keys and buttons.
import { el, plainButton, setAttr, svg } from "../../dom";
import { looksOf } from "./looks";

export interface Bounds {
  left: number;
  top: number;
  width: number;
  height: number;
}

const [LEAST, MOST] = [0.1, 6];
/** Fitting makes a drawing no smaller: its text has 11 px at this scale, and what runs is kept in sight instead. */
const LEAST_FIT = 1;
const STEP = 1.25;
const WHEEL_RATE = 0.0015;
/** Pixels of one line of a wheel that counts lines. */
const LINE_PX = 16;
const PAN_PX = 40;
/** A pointer that moves less than this clicks. */
const CLICK_PX = 4;
const PAD_PX = 8;

/** Where the origin of a drawing is along one axis (px): in the middle if it fits `room`, else so that `watched` is in
 * sight and no room is left empty. */
function placed(room: number, scale: number, from: number, length: number, watched: number): number {
  if (scale * length <= room) return room / 2 - scale * (from + length / 2);
  const wanted = room / 2 - scale * watched;
  return Math.min(Math.max(wanted, room - PAD_PX - scale * (from + length)), PAD_PX - scale * from);
}

/** The least that holds both. */
function joined(one: Bounds, other: Bounds): Bounds {
  const [left, top] = [Math.min(one.left, other.left), Math.min(one.top, other.top)];
  const right = Math.max(one.left + one.width, other.left + other.width);
  const bottom = Math.max(one.top + one.height, other.top + other.height);
  return { left, top, width: right - left, height: bottom - top };
}

export class Viewport {
  readonly root: HTMLElement;
  /** The group for the contents of the drawing. */
  readonly world = svg("g", { class: "world" });
  private readonly look;
  private readonly pointers = new Map<number, { x: number; y: number }>();
  private dragged = false;
  /** Its width and height (px): to ask for them after a change costs a layout of the page. */
  private size = { width: 0, height: 0 };
  /** Parts of the drawing that stay in sight where the whole does not fit; the first most of all. */
  private watched: Bounds[] = [];
  /** Called when the drawing has another place, with what tells whether a part is whole in sight. */
  onPlaced: (isWhole: (part: Bounds) => boolean) => void = () => {};

  constructor(
    key: string,
    label: string,
    private bounds: Bounds,
    /** A small drawing is not made larger than this to fit. */
    private readonly fitMost: number,
  ) {
    this.look = looksOf(key);
    const drawing = svg("svg", { class: "drawing", role: "group", "aria-label": label }, this.world);
    const keys = "arrows pan, plus and minus zoom, 0 fits";
    this.root = el("div", { class: "viewport", tabindex: 0, role: "group", "aria-label": `${label}: ${keys}` });
    this.root.append(drawing, this.buttons());
    this.listen();
    this.apply();
    new ResizeObserver(() => {
      const { width, height } = drawing.getBoundingClientRect();
      this.size = { width, height };
      this.apply();
    }).observe(drawing);
  }

  /** The drawing has other bounds now. */
  resize(bounds: Bounds): void {
    this.bounds = bounds;
    this.apply();
  }

  fit(): void {
    this.look.fit = true;
    this.apply();
  }

  /** Zooms by `factor` around a point of the element, its centre if none is given. */
  zoom(factor: number, at = this.centre()): void {
    const { look } = this;
    const scale = Math.min(Math.max(look.scale * factor, LEAST), MOST);
    const ratio = scale / look.scale;
    Object.assign(look, { fit: false, scale, x: at.x - ratio * (at.x - look.x), y: at.y - ratio * (at.y - look.y) });
    this.apply();
  }

  pan(x: number, y: number): void {
    Object.assign(this.look, { fit: false, x: this.look.x + x, y: this.look.y + y });
    this.apply();
  }

  /** Pans so that a part of the drawing is in the middle, where it is not well inside. */
  reveal(part: Bounds): void {
    const { look } = this;
    if (look.fit) return this.watch([part]);
    const { x, y } = { x: part.left + part.width / 2, y: part.top + part.height / 2 };
    const [atX, atY] = [look.x + look.scale * x, look.y + look.scale * y];
    const { width, height } = this.size;
    const inside = atX > 0.15 * width && atX < 0.85 * width && atY > 0.15 * height && atY < 0.85 * height;
    if (!inside) this.pan(width / 2 - atX, height / 2 - atY);
  }

  /** Keeps parts of the drawing in sight, as many as there is room for, until a person pans or zooms. */
  watch(parts: Bounds[]): void {
    if (JSON.stringify(this.watched) === JSON.stringify(parts)) return;
    this.watched = parts;
    if (this.look.fit) this.apply();
  }

  /** The middle of the watched parts that there is room for. */
  private middle(scale: number): { x: number; y: number } {
    const { bounds, size } = this;
    const [first, ...others] = this.watched;
    if (first === undefined) return { x: bounds.left + bounds.width / 2, y: bounds.top };
    const isRoom = ({ width, height }: Bounds) =>
      scale * width <= size.width - 2 * PAD_PX && scale * height <= size.height - 2 * PAD_PX;
    let all = first;
    for (const part of others) {
      const more = joined(all, part);
      if (isRoom(more)) all = more;
    }
    return { x: all.left + all.width / 2, y: all.top + all.height / 2 };
  }

  private centre(): { x: number; y: number } {
    return { x: this.size.width / 2, y: this.size.height / 2 };
  }

  private apply(): void {
    const { look, bounds } = this;
    const { width, height } = this.size;
    if (look.fit) {
      // A hidden drawing has no size; it gets one when it is shown.
      if (width === 0 || height === 0) return;
      const fits = Math.min((width - 2 * PAD_PX) / bounds.width, (height - 2 * PAD_PX) / bounds.height);
      look.scale = Math.min(Math.max(fits, LEAST_FIT), this.fitMost);
      const { x, y } = this.middle(look.scale);
      look.x = placed(width, look.scale, bounds.left, bounds.width, x);
      look.y = placed(height, look.scale, bounds.top, bounds.height, y);
    }
    const [x, y, scale] = [look.x.toFixed(2), look.y.toFixed(2), look.scale.toFixed(4)];
    setAttr(this.world, "transform", `translate(${x} ${y}) scale(${scale})`);
    const inside = (from: number, length: number, room: number) => from >= 0 && from + look.scale * length <= room;
    this.onPlaced(
      (part) =>
        inside(look.x + look.scale * part.left, part.width, width) &&
        inside(look.y + look.scale * part.top, part.height, height),
    );
  }

  private buttons(): HTMLElement {
    const make = (text: string, about: string, run: () => void) => {
      // A sign alone has no name.
      const name = text.length === 1 ? about : false;
      return plainButton({ class: "button small", title: about, "aria-label": name }, run, text);
    };
    return el(
      "div",
      { class: "zoom-buttons segments", role: "group", "aria-label": "Zoom" },
      make("−", "Zoom out (-)", () => this.zoom(1 / STEP)),
      make("+", "Zoom in (+)", () => this.zoom(STEP)),
      make("Fit", "Fit the drawing into its place (0)", () => this.fit()),
      make("1:1", "Show the drawing in its own size", () => this.zoom(1 / this.look.scale)),
    );
  }

  private point({ clientX, clientY }: MouseEvent): { x: number; y: number } {
    const { left, top } = this.root.getBoundingClientRect();
    return { x: clientX - left, y: clientY - top };
  }

  private listen(): void {
    const { root } = this;
    root.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    root.addEventListener("keydown", (event) => this.press(event));
    root.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || (event.target as Element).closest(".zoom-buttons") !== null) return;
      if (this.pointers.size === 0) this.dragged = false;
      this.pointers.set(event.pointerId, this.point(event));
    });
    root.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"] as const) {
      root.addEventListener(end, ({ pointerId }) => this.pointers.delete(pointerId));
    }
    // The browser reports the end of a drag as a click, which must not act on the node under it.
    const end = (event: MouseEvent) => {
      if (this.dragged) event.stopPropagation();
      this.dragged = false;
    };
    root.addEventListener("click", end, { capture: true });
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE_PX * event.deltaY : event.deltaY;
    this.zoom(Math.exp(-WHEEL_RATE * pixels), this.point(event));
  }

  private move(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (before === undefined) return;
    if (event.buttons === 0) {
      // It was let go outside.
      this.pointers.delete(event.pointerId);
      return;
    }
    const now = this.point(event);
    const far = Math.hypot(now.x - before.x, now.y - before.y) >= CLICK_PX;
    if (!this.dragged && !far) return;
    if (!this.dragged) this.root.setPointerCapture(event.pointerId);
    this.dragged = true;
    this.pointers.set(event.pointerId, now);
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (other === undefined) {
      this.pan(now.x - before.x, now.y - before.y);
      return;
    }
    // Two fingers: their distance zooms, around the one that rests.
    const apart = (point: { x: number; y: number }) => Math.max(Math.hypot(point.x - other.x, point.y - other.y), 1);
    this.zoom(apart(now) / apart(before), other);
  }

  private press(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const keys: Record<string, () => void> = {
      ArrowLeft: () => this.pan(PAN_PX, 0),
      ArrowRight: () => this.pan(-PAN_PX, 0),
      ArrowUp: () => this.pan(0, PAN_PX),
      ArrowDown: () => this.pan(0, -PAN_PX),
      "+": () => this.zoom(STEP),
      "=": () => this.zoom(STEP),
      "-": () => this.zoom(1 / STEP),
      "0": () => this.fit(),
    };
    const run = keys[event.key];
    if (run === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    run();
  }
}
