// One line of an outline: a node with its status, and what runs below it.
import { el, setAttr, setText } from "../../dom";
import { breakDot } from "../breaks/dot";
import { aboutNode, type Place } from "./place";
import { type Shape, signOf } from "./shape";

const MARKS: Record<string, [string, string]> = {
  R: ["▶", "running"],
  S: ["✓", "succeeded"],
  F: ["✗", "failed"],
};

export class Line {
  readonly row: HTMLElement;
  private readonly mark = el("span", { class: "mark", role: "img" });
  private readonly time = el("span", { class: "num dim" });
  private readonly inside = el("span", { class: "inside" });
  /** Simulated time since when the node has its status. */
  private readonly since: () => number | null;
  private letter = "";
  private told = "";

  constructor(place: Place, shape: Shape, index: number) {
    const { context, graph } = place;
    this.since = () => context.store.since.of(place.at, index);
    const { name = "?", kind = "" } = graph.nodes[index] ?? {};
    const sign = signOf(kind);
    const tellsKind = kind.toLowerCase() !== name.toLowerCase() && sign === "";
    const isParent = (shape.children[index] ?? []).length > 0;
    const depth = shape.depth[index] ?? 0;
    this.row = el(
      "div",
      { class: "tree-node", role: "treeitem", tabindex: -1, "aria-level": depth + 1, title: aboutNode(graph, index) },
      place.name === "beside" ? null : breakDot(context, name, -1),
      el("span", { class: isParent ? "chevron" : "chevron none", "aria-hidden": "true" }),
      this.mark,
      el("span", { class: "sign" }, sign),
      el("span", { class: "name" }, name),
      el("span", { class: "dim kind" }, tellsKind ? kind : ""),
      this.inside,
      this.time,
    );
    this.row.style.setProperty("--depth", String(depth));
    this.show("I");
  }

  show(letter: string): void {
    if (this.letter === letter) return;
    this.letter = letter;
    this.row.dataset.status = letter;
    const [sign, word] = MARKS[letter] ?? ["·", "not ticked"];
    setText(this.mark, sign);
    setAttr(this.mark, "aria-label", word);
  }

  /** Names the node that runs within the collapsed subtree of this one. */
  tellInside(name: string | null): void {
    const words = name === null ? "" : `▶ ${name}`;
    if (words === this.told) return;
    this.told = words;
    setText(this.inside, words);
  }

  /** Shows for how long the node has run; whether it runs. */
  tellTime(now: number): boolean {
    const isRunning = this.letter === "R";
    const since = isRunning ? this.since() : null;
    setText(this.time, since === null || now < since ? "" : `${(now - since).toFixed(1)} s`);
    return isRunning;
  }
}
