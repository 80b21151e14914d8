// A search among the nodes of a graph: what fits is marked, Enter goes from one to
// the next.
import type { Graph } from "../../../net/protocol";
import { el, setText } from "../../dom";
import type { GraphView } from "./place";

const ABOUT = "Find nodes (Ctrl+F); Enter goes to the next";

/** Nodes whose name, type or id has `text` in it. */
export function matches(graph: Graph, text: string): number[] {
  const wanted = text.trim().toLowerCase();
  if (wanted === "") return [];
  const fits = (words: string) => words.toLowerCase().includes(wanted);
  return graph.nodes.flatMap(({ name, kind, id }, index) => (fits(name) || fits(kind) || fits(id) ? [index] : []));
}

export class Finder {
  readonly field = el("input", { type: "search", placeholder: "find", "aria-label": "Find nodes", title: ABOUT });
  readonly count = el("span", { class: "find-count num dim", role: "status" });
  private all: number[] = [];
  /** Place of the match that is selected; -1 before the first. */
  private at = -1;

  constructor(
    private readonly graph: () => Graph | undefined,
    private readonly view: () => GraphView | null,
  ) {
    this.field.addEventListener("input", () => {
      this.at = -1;
      this.refresh();
    });
    this.field.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.step(event.shiftKey ? -1 : 1);
      else if (event.key === "Escape" && this.field.value !== "") this.clear();
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  /** Ctrl+F within `place` leads to the field, until the function that is returned is called. */
  listen(place: HTMLElement): () => void {
    const press = (event: KeyboardEvent) => {
      const asks = (event.ctrlKey || event.metaKey) && !event.altKey && event.key.toLowerCase() === "f";
      // The search is in the graph that has the pointer or the focus.
      if (!asks || !place.matches(":hover, :focus-within") || !place.checkVisibility()) return;
      event.preventDefault();
      this.field.focus();
      this.field.select();
    };
    document.addEventListener("keydown", press);
    return () => document.removeEventListener("keydown", press);
  }

  /** Marks the matches in the view as it is now. */
  refresh(): void {
    const graph = this.graph();
    this.all = graph === undefined ? [] : matches(graph, this.field.value);
    this.view()?.mark(new Set(this.all));
    this.showResult();
  }

  private step(by: number): void {
    const { length } = this.all;
    if (length === 0) return;
    this.at = this.at < 0 && by < 0 ? length - 1 : (this.at + by + length) % length;
    this.view()?.select(this.all[this.at] ?? 0);
    this.showResult();
  }

  private clear(): void {
    this.field.value = "";
    this.at = -1;
    this.refresh();
  }

  private showResult(): void {
    const { length } = this.all;
    const none = this.field.value.trim() === "";
    setText(this.count, none ? "" : this.at < 0 ? `${length}` : `${this.at + 1}/${length}`);
  }
}
