// How graphs are shown: a tree as an outline or as a drawing, a machine as a drawing, a
// table or both; the choice is kept in the browser.
import { el, plainButton, setAttr } from "../../dom";

/** One of several, with their labels and what they are. */
class Mode {
  private chosen: string;
  private readonly listeners = new Set<() => void>();

  constructor(
    private readonly key: string,
    private readonly all: [name: string, label: string, about: string][],
  ) {
    this.chosen = this.stored();
  }

  get name(): string {
    return this.chosen;
  }

  /** Calls `listener` when another one is chosen. */
  on(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  buttons(): HTMLElement {
    const root = el("div", { class: "segments mode", role: "group", "aria-label": "Shown as" });
    const nodes = this.all.map(([name, label, about]) => {
      const node = plainButton({ class: "button small", title: about }, () => this.choose(name), label);
      root.append(node);
      return { name, node };
    });
    const show = () => {
      for (const { name, node } of nodes) setAttr(node, "aria-pressed", String(name === this.chosen));
    };
    const off = this.on(() => (root.isConnected ? show() : off()));
    show();
    return root;
  }

  private choose(name: string): void {
    this.chosen = name;
    try {
      localStorage.setItem(this.key, name);
    } catch {
      // It holds until the page is closed.
    }
    for (const listener of [...this.listeners]) listener();
  }

  /** What the browser keeps; the first where it keeps nothing. */
  private stored(): string {
    const first = this.all[0]?.[0] ?? "";
    try {
      const kept = localStorage.getItem(this.key);
      return this.all.some(([name]) => name === kept) ? (kept ?? first) : first;
    } catch {
      return first;
    }
  }
}

export const treeMode = new Mode("robocell.tree", [
  ["outline", "Outline", "Indented lines"],
  ["tree", "Tree", "A drawing, from left to right"],
]);

export const machineMode = new Mode("robocell.machine", [
  ["both", "Both", "Drawing and table"],
  ["graph", "Graph", "The drawing alone"],
  ["table", "Table", "The table alone"],
]);
