// Short texts that stand at points of the cell. They are elements over the
// canvas: sharp at every quality, and only ever text.
import { type Camera, Vector3 } from "three";

/** A part of the picture (pixels). */
export interface Area {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

interface Size {
  width: number;
  height: number;
}

interface Pixel {
  x: number;
  y: number;
}

interface Label {
  element: HTMLElement;
  at: Vector3;
  used: boolean;
  /** Null until it was measured (pixels). */
  size: Size | null;
  /** It is beside its point, which it would cover. */
  beside: boolean;
  /** Of a text beside its point: points it never covers, and points it covers only where there is no other place. */
  about: About;
  /** It stays at the border where its point is outside of the picture. */
  kept: boolean;
  /** From its point to its lower edge (pixels). */
  lift: number;
}

export interface About {
  /** Points around the subject of the text. */
  shape: Vector3[];
  /** Points along links and objects near the subject. */
  near: Vector3[];
}

/** From a point to a text beside it (pixels). */
const BESIDE_PX = 28;
/** A text this near to the middle line of a link covers the link (pixels). */
const LINK_PX = 10;
/** From a point to a text above it (pixels): usual, of a target with its mark, of an outcome above other texts of the tool. */
const LIFT_PX = 5;
const MARK_LIFT_PX = 24;
const OUTCOME_LIFT_PX = 27;
/** Between a text and the border of the picture (pixels). */
const MARGIN_PX = 8;
/** Between a text and the area it may not cover (pixels). */
const GAP_PX = 6;

const NOTHING: About = { shape: [], near: [] };

function meet(one: Area, other: Area): boolean {
  return one.left < other.right && one.right > other.left && one.top < other.bottom && one.bottom > other.top;
}

function put(left: number, top: number, { width, height }: Size): Area {
  return { left, top, right: left + width, bottom: top + height };
}

function isInside({ left, top, right, bottom }: Area, width: number, height: number): boolean {
  return Math.min(left, top, width - right, height - bottom) >= MARGIN_PX;
}

/** From a point to a part of the picture; 0 within it (pixels). */
function distance({ x, y }: Pixel, { left, top, right, bottom }: Area): number {
  return Math.hypot(Math.max(left - x, 0, x - right), Math.max(top - y, 0, y - bottom));
}

function pixels(point: Vector3, camera: Camera, width: number, height: number): Pixel {
  const { x, y } = point.clone().project(camera);
  return { x: (0.5 + x / 2) * width, y: (0.5 - y / 2) * height };
}

/** The four places of a text of `size` around `area`: those beside it at `top`, those above and below it at `left`. */
function around(area: Area, left: number, top: number, size: Size): Area[] {
  return [
    put(area.right + GAP_PX, top, size),
    put(area.left - size.width - GAP_PX, top, size),
    put(left, area.top - size.height - GAP_PX, size),
    put(left, area.bottom + GAP_PX, size),
  ];
}

/** Left and top of a text that covers nothing of its subject, and as little as possible of the links and objects near it. */
function beside(at: Pixel, label: Label, size: Size, camera: Camera, picture: Size): [number, number] {
  const { width, height } = picture;
  const seen = (point: Vector3) => pixels(point, camera, width, height);
  const [shape, near] = [[...label.about.shape.map(seen), at], label.about.near.map(seen)];
  const [xs, ys] = [shape.map(({ x }) => x), shape.map(({ y }) => y)];
  const reach = BESIDE_PX - GAP_PX;
  const area = {
    left: Math.min(...xs, at.x - reach),
    right: Math.max(...xs, at.x + reach),
    top: Math.min(...ys, at.y - reach),
    bottom: Math.max(...ys, at.y + reach),
  };
  const top = at.y - LIFT_PX - size.height;
  const places = around(area, at.x - size.width / 2, top, size).filter((place) => isInside(place, width, height));
  const covered = (place: Area) => near.filter((point) => distance(point, place) < LINK_PX).length;
  // Of equal ones the first.
  const [best] = places.sort((one, other) => covered(one) - covered(other));
  return best === undefined ? [area.right + GAP_PX, top] : [best.left, best.top];
}

/** The place of a text nearest to `wanted` that is in the picture and covers none of `taken`; `at`: the point that it is about. */
function free(wanted: Area, at: Pixel, taken: Area[], width: number, height: number): Area {
  const { left, top } = wanted;
  const size = { width: wanted.right - left, height: wanted.bottom - top };
  if (!taken.some((area) => meet(wanted, area))) return wanted;
  // The sides of what has the point in it are all as good.
  const isWithin = taken.some((area) => distance(at, area) === 0);
  const away = (area: Area) => (isWithin ? Math.hypot(area.left - left, area.top - top) : distance(at, area));
  const others = taken
    .flatMap((area) => around(area, left, top, size))
    .filter((area) => isInside(area, width, height) && !taken.some((one) => meet(area, one)));
  return others.sort((one, other) => away(one) - away(other))[0] ?? wanted;
}

export class Labels {
  private readonly layer = document.createElement("div");
  private readonly labels = new Map<string, Label>();
  /** Of the texts of a kind and length: measuring costs a layout, and other digits are as wide. */
  private readonly sizes = new Map<string, Size>();

  constructor(element: HTMLElement) {
    this.layer.className = "labels";
    element.append(this.layer);
  }

  /** Starts a new set: labels that are not shown again are removed. */
  begin(): void {
    for (const label of this.labels.values()) label.used = false;
  }

  /** Says `text` at `at`; `key` names the label, `kind` is a class of the style sheet. */
  show(key: string, text: string, at: Vector3, kind = "", about = NOTHING): HTMLElement {
    let label = this.labels.get(key);
    if (label === undefined) {
      const element = document.createElement("div");
      const usual = { size: null, beside: false, about: NOTHING, kept: false, lift: LIFT_PX };
      label = { element, at: new Vector3(), used: true, ...usual };
      this.layer.append(label.element);
      this.labels.set(key, label);
    }
    label.used = true;
    label.at.copy(at);
    label.about = about;
    if (label.element.className !== `label ${kind}`) {
      label.element.className = `label ${kind}`;
      label.size = null;
    }
    label.beside = kind.startsWith("load");
    label.kept = kind.endsWith("kept");
    label.lift = kind.startsWith("outcome") ? OUTCOME_LIFT_PX : label.kept ? MARK_LIFT_PX : LIFT_PX;
    const before = label.element.textContent ?? "";
    if (before !== text) {
      label.element.textContent = text;
      if (before.length !== text.length) label.size = null;
    }
    return label.element;
  }

  /** Without a picture there is nothing to name. */
  hide(isHidden: boolean): void {
    this.layer.hidden = isHidden;
  }

  /** Ends the set that `begin` began. */
  end(): void {
    for (const [key, { element, used }] of this.labels) {
      if (used) continue;
      element.remove();
      this.labels.delete(key);
    }
  }

  private size(element: HTMLElement): Size {
    const key = `${element.className} ${element.textContent?.length ?? 0}`;
    const known = this.sizes.get(key) ?? { width: element.offsetWidth, height: element.offsetHeight };
    this.sizes.set(key, known);
    return known;
  }

  /** Moves all to where `camera` sees their points; no text covers the handles. */
  place(camera: Camera, width: number, height: number, handles: Area | null): void {
    const at = new Vector3();
    const taken = handles === null ? [] : [handles];
    for (const label of this.labels.values()) {
      at.copy(label.at).project(camera);
      const isNear = Math.abs(at.x) < 1.1 && Math.abs(at.y) < 1.1;
      const seen = at.z < 1 && (isNear || label.kept);
      label.element.style.display = seen ? "" : "none";
      if (!seen) continue;
      label.size ??= this.size(label.element);
      const { width: wide, height: tall } = label.size;
      // A text at the border stays in the picture.
      const within = (wanted: number, length: number, room: number) =>
        Math.max(MARGIN_PX, Math.min(wanted, room - MARGIN_PX - length));
      const [x, y] = [(0.5 + at.x / 2) * width, (0.5 - at.y / 2) * height];
      const [left, top] = label.beside
        ? beside({ x, y }, label, label.size, camera, { width, height })
        : [x - wide / 2, y - label.lift - tall];
      const wanted = put(within(left, wide, width), within(top, tall, height), label.size);
      const area = free(wanted, { x, y }, taken, width, height);
      if (area !== wanted) taken.push(area);
      label.element.style.transform = `translate(${area.left.toFixed(1)}px, ${area.top.toFixed(1)}px)`;
    }
  }
}
