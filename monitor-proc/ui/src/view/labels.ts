// Short texts that stand at points of the cell. They are elements over the
// canvas: sharp at every quality, and only ever text.
import { type Camera, Vector3 } from "three";

interface Label {
  element: HTMLElement;
  at: Vector3;
  used: boolean;
  /** Half its width (pixels); null until it was measured. */
  half: number | null;
  /** At the right of its point, which it would cover. */
  beside: boolean;
  /** It stays at the border where its point is outside of the picture. */
  kept: boolean;
}

/** From a point to a text beside it (pixels). */
const BESIDE_PX = 28;
/** A text above its point has room there (pixels). */
const HIGHEST_PX = 30;

export class Labels {
  private readonly layer = document.createElement("div");
  private readonly labels = new Map<string, Label>();
  /** Half the width of the texts of a kind and length (pixels): measuring costs a layout, and other digits are as wide. */
  private readonly halves = new Map<string, number>();

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
      label = { element: document.createElement("div"), at: new Vector3(), used: true, half: null, beside: false, kept: false };
      this.layer.append(label.element);
      this.labels.set(key, label);
    }
    label.used = true;
    label.at.copy(at);
    if (label.element.className !== `label ${kind}`) {
      label.element.className = `label ${kind}`;
      label.half = null;
    }
    label.beside = kind.startsWith("load");
    label.kept = kind.endsWith("kept");
    const before = label.element.textContent ?? "";
    if (before !== text) {
      label.element.textContent = text;
      if (before.length !== text.length) label.half = null;
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

  private half(element: HTMLElement): number {
    const key = `${element.className} ${element.textContent?.length ?? 0}`;
    const known = this.halves.get(key) ?? element.offsetWidth / 2;
    this.halves.set(key, known);
    return known;
  }

  /** Moves all to where `camera` sees their points. */
  place(camera: Camera, width: number, height: number): void {
    const at = new Vector3();
    for (const label of this.labels.values()) {
      at.copy(label.at).project(camera);
      const isNear = Math.abs(at.x) < 1.1 && Math.abs(at.y) < 1.1;
      const seen = at.z < 1 && (isNear || label.kept);
      label.element.style.display = seen ? "" : "none";
      if (!seen) continue;
      label.half ??= this.half(label.element);
      // A text at the border stays in the picture.
      const wanted = (0.5 + at.x / 2) * width + (label.beside ? label.half + BESIDE_PX : 0);
      const x = Math.min(Math.max(wanted, label.half), Math.max(label.half, width - label.half));
      const y = Math.min(Math.max((0.5 - at.y / 2) * height, HIGHEST_PX), height);
      label.element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -130%)`;
    }
  }
}
