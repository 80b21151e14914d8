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

interface Label {
  element: HTMLElement;
  at: Vector3;
  used: boolean;
  /** Null until it was measured (pixels). */
  size: Size | null;
  /** At the right of its point, which it would cover. */
  beside: boolean;
  /** It stays at the border where its point is outside of the picture. */
  kept: boolean;
  /** From its point to its lower edge (pixels). */
  lift: number;
}

/** From a point to a text beside it (pixels). */
const BESIDE_PX = 28;
/** From a point to a text above it (pixels): usual, of a target with its mark, of an outcome above other texts of the tool. */
const LIFT_PX = 5;
const MARK_LIFT_PX = 24;
const OUTCOME_LIFT_PX = 27;
/** Between a text and the border of the picture (pixels). */
const MARGIN_PX = 8;
/** Between a text and what it may not cover (pixels). */
const GAP_PX = 6;

function meet(one: Area, other: Area): boolean {
  return one.left < other.right && one.right > other.left && one.top < other.bottom && one.bottom > other.top;
}

/** The place of a text nearest to `wanted` that is in the picture and covers none of `taken`. */
function free(wanted: Area, taken: Area[], width: number, height: number): Area {
  const { left, top } = wanted;
  const [wide, tall] = [wanted.right - left, wanted.bottom - top];
  const put = (x: number, y: number): Area => ({ left: x, top: y, right: x + wide, bottom: y + tall });
  if (!taken.some((area) => meet(wanted, area))) return wanted;
  const isInside = (area: Area) =>
    area.left >= MARGIN_PX && area.top >= MARGIN_PX && area.right <= width - MARGIN_PX && area.bottom <= height - MARGIN_PX;
  const away = (area: Area) => Math.hypot(area.left - left, area.top - top);
  const others = taken
    .flatMap((area) => [
      put(left, area.top - tall - GAP_PX),
      put(left, area.bottom + GAP_PX),
      put(area.left - wide - GAP_PX, top),
      put(area.right + GAP_PX, top),
    ])
    .filter((area) => isInside(area) && !taken.some((one) => meet(area, one)));
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

  /** Begins a new set: what is not said again goes. */
  begin(): void {
    for (const label of this.labels.values()) label.used = false;
  }

  /** Says `text` at `at`; `key` names the label, `kind` is a class of the style sheet. */
  show(key: string, text: string, at: Vector3, kind = ""): HTMLElement {
    let label = this.labels.get(key);
    if (label === undefined) {
      label = { element: document.createElement("div"), at: new Vector3(), used: true, size: null, beside: false, kept: false, lift: LIFT_PX };
      this.layer.append(label.element);
      this.labels.set(key, label);
    }
    label.used = true;
    label.at.copy(at);
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
      const left = within((0.5 + at.x / 2) * width + (label.beside ? BESIDE_PX : -wide / 2), wide, width);
      const top = within((0.5 - at.y / 2) * height - label.lift - tall, tall, height);
      const wanted = { left, top, right: left + wide, bottom: top + tall };
      const area = free(wanted, taken, width, height);
      if (area !== wanted) taken.push(area);
      label.element.style.transform = `translate(${area.left.toFixed(1)}px, ${area.top.toFixed(1)}px)`;
    }
  }
}
