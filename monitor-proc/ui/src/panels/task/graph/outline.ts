// A behaviour tree as an outline: indented lines with the status of each node;
// subtrees collapse.
import { el, reveal, setAttr } from "../../dom";
import { toggleBreak } from "../breaks/state";
import { type Folds, foldsOf } from "./folds";
import { Line } from "./outline-line";
import { type GraphView, keyOf, type Place } from "./place";
import { hidden, runningBelow, type Shape, shapeOf, unfold } from "./shape";

export class Outline implements GraphView {
  readonly root: HTMLElement;
  private readonly shape: Shape;
  private readonly folds: Folds;
  private readonly lines: Line[];
  private chosen = 0;
  private deepest = -1;
  private letters = "";
  /** Lines whose running time is shown. */
  private readonly timed = new Set<Line>();

  constructor(private readonly place: Place) {
    const { context, graph } = place;
    this.root = el("div", { class: "tree", role: "tree", "aria-label": `The tree ${graph.name}` });
    this.shape = shapeOf(graph);
    this.folds = foldsOf(keyOf(place), graph, this.shape);
    this.lines = graph.nodes.map((_, index) => new Line(place, this.shape, index));
    this.root.append(...chunks(this.lines));
    this.listen();
    if (place.name !== "beside") {
      context.pulse.add(this.root, () => {
        const now = context.snapshot?.time ?? 0;
        for (const line of this.timed) if (!line.tellTime(now)) this.timed.delete(line);
      });
    }
    this.fold();
    this.choose(0, false);
  }

  show(): void {
    const { store } = this.place.context;
    const letters = store.letters[this.place.at] ?? "";
    if (letters === this.letters) return;
    this.deepest = letters.lastIndexOf("R");
    for (const [index, line] of this.lines.entries()) {
      const letter = letters[index] ?? "I";
      if (letter === this.letters[index]) continue;
      line.show(letter);
      if (letter === "R") this.timed.add(line);
    }
    this.letters = letters;
    this.tellInside();
  }

  follow(): void {
    // The end of a tree that is over is at what ended last.
    const ended = Math.max(this.letters.lastIndexOf("S"), this.letters.lastIndexOf("F"));
    // What runs within a collapsed node is told at that node.
    let at: number | null = this.deepest < 0 ? ended : this.deepest;
    while (at !== null && this.lines[at]?.row.hidden === true) at = this.shape.parents[at] ?? null;
    if (at !== null && at >= 0) reveal(this.body, this.lines[at]?.row);
  }

  mark(found: ReadonlySet<number>): void {
    for (const [index, { row }] of this.lines.entries()) row.classList.toggle("found", found.has(index));
  }

  select(node: number): void {
    unfold(this.place.graph, this.shape, this.folds, node);
    this.choose(node, false);
    reveal(this.body, this.lines[node]?.row);
  }

  private get body(): Element | null {
    return this.root.closest(".graph-body");
  }

  private id(index: number): string {
    return this.place.graph.nodes[index]?.id ?? "";
  }

  private isParent(index: number): boolean {
    return (this.shape.children[index] ?? []).length > 0;
  }

  private isShut(index: number): boolean {
    return this.folds.has(this.id(index));
  }

  /** Makes `index`, or the line it is collapsed into, the line that the keys act on. */
  private choose(index: number, focus: boolean): void {
    let at = index;
    while (this.lines[at]?.row.hidden === true) at = this.shape.parents[at] ?? 0;
    const before = this.lines[this.chosen]?.row;
    const next = this.lines[at]?.row;
    if (before === undefined || next === undefined) return;
    before.tabIndex = -1;
    setAttr(before, "aria-selected", null);
    this.chosen = at;
    next.tabIndex = 0;
    setAttr(next, "aria-selected", "true");
    if (!focus) return;
    next.focus({ preventScroll: true });
    reveal(this.body, next);
  }

  private fold(): void {
    const away = hidden(this.place.graph, this.shape, this.folds);
    for (const [index, { row }] of this.lines.entries()) {
      row.hidden = away[index] === true;
      if (this.isParent(index)) setAttr(row, "aria-expanded", String(!this.isShut(index)));
    }
    this.choose(this.chosen, this.root.contains(document.activeElement));
    this.tellInside();
  }

  private tellInside(): void {
    const { graph } = this.place;
    const running = runningBelow(this.shape, this.letters);
    for (const [index, line] of this.lines.entries()) {
      const runs = this.isShut(index) ? (running[index] ?? null) : null;
      line.tellInside(runs === null ? null : (graph.nodes[runs]?.name ?? ""));
    }
  }

  private listen(): void {
    for (const [index, { row }] of this.lines.entries()) {
      row.addEventListener("focus", () => this.choose(index, false));
      row.addEventListener("click", ({ target }) => {
        this.choose(index, true);
        const onChevron = target instanceof Element && target.closest(".chevron") !== null;
        if (onChevron && this.isParent(index)) this.folds.toggle(this.id(index));
        else this.place.onNode(index);
      });
      row.addEventListener("dblclick", ({ target }) => {
        const onName = target instanceof Element && target.closest(".chevron, button") === null;
        if (onName && this.isParent(index)) this.folds.toggle(this.id(index));
      });
    }
    this.root.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !this.press(event.key)) return;
      event.preventDefault();
      event.stopPropagation();
    });
    const off = this.folds.on(() => (this.root.isConnected ? this.fold() : off()));
  }

  /** Does what `key` means in a tree; whether it means something. */
  private press(key: string): boolean {
    const { chosen } = this;
    const keys: Record<string, () => void> = {
      ArrowDown: () => this.step(1),
      ArrowUp: () => this.step(-1),
      Home: () => this.step(-this.lines.length),
      End: () => this.step(this.lines.length),
      ArrowRight: () => {
        if (this.isShut(chosen)) this.folds.set(this.id(chosen), false);
        else if (this.isParent(chosen)) this.step(1);
      },
      ArrowLeft: () => {
        if (this.isParent(chosen) && !this.isShut(chosen)) this.folds.set(this.id(chosen), true);
        else this.choose(this.shape.parents[chosen] ?? chosen, true);
      },
      Enter: () => this.place.onNode(chosen),
      b: () => toggleBreak(this.place.context, this.place.graph.nodes[chosen]?.name ?? ""),
    };
    keys[key]?.();
    return key in keys;
  }

  private step(by: number): void {
    const shown = this.lines.flatMap(({ row }, index) => (row.hidden ? [] : [index]));
    const next = Math.min(Math.max(shown.indexOf(this.chosen) + by, 0), shown.length - 1);
    this.choose(shown[next] ?? 0, true);
  }
}

/** Lines of one element: the browser lays out and draws only the elements in view. */
const CHUNK = 64;

function chunks(lines: readonly Line[]): HTMLElement[] {
  const count = Math.ceil(lines.length / CHUNK);
  return Array.from({ length: count }, (_, chunk) => {
    const rows = lines.slice(CHUNK * chunk, CHUNK * (chunk + 1)).map(({ row }) => row);
    return el("div", { class: count > 1 ? "tree-chunk" : "", role: "none" }, ...rows);
  });
}
