// Which of the policy's graphs is shown: each arm may have its own tree.
import { phaseOf } from "../../net/phases";
import type { Graph } from "../../net/protocol";
import type { Store } from "../../net/store";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr } from "../dom";

export class GraphChoice {
  readonly root = el("div", { class: "segments graph-choice", role: "group", "aria-label": "Graph", hidden: true });
  index = 0;
  private demo = "";
  /** A person chose the graph, or a node of it. */
  private isKept = false;
  private readonly listeners = new Set<() => void>();
  private readonly store: Store;

  constructor(context: PanelContext) {
    const { store } = context;
    this.store = store;
    // While a task restarts it shows nothing: the last picture stays, as
    // long as it is of the same demo.
    store.on("graphs", (graphs) => graphs.length > 0 && this.fill(graphs));
    store.on("scene", ({ demo }) => {
      if (demo === this.demo) return;
      this.demo = demo;
      this.isKept = false;
      this.fill(store.graphs);
    });
    this.fill(store.graphs);
    context.pulse.add(this.root, () => this.follow());
  }

  /** From now on the graph is shown until another one is pressed. */
  keep(): void {
    this.isKept = true;
  }

  /** Shows the graph of the arm whose phase is the title of the task. */
  private follow(): void {
    // A graph under the pointer or with the focus stays: a person may be reading it.
    if (this.isKept || this.root.parentElement?.matches(":hover, :focus-within") === true) return;
    const phase = phaseOf(this.store);
    const prefix = (name: string) => `${name.toUpperCase().replace(/[^A-Z0-9]/g, "_")}_`;
    const at = this.store.graphs.findIndex(({ name }) => phase.startsWith(prefix(name)));
    if (at >= 0 && at !== this.index) this.choose(at);
  }

  get graph(): Graph | undefined {
    return this.store.graphs[this.index];
  }

  /** Calls `listener` when another graph is chosen, or its picture is new. */
  on(listener: () => void): void {
    this.listeners.add(listener);
  }

  private fill(graphs: Graph[]): void {
    const buttons = graphs.map(({ name }, index) => {
      const run = () => {
        this.keep();
        this.choose(index);
      };
      return plainButton({ class: "button small" }, run, name);
    });
    this.root.replaceChildren(...buttons);
    this.root.hidden = graphs.length < 2;
    this.choose(this.index < graphs.length ? this.index : 0);
  }

  private choose(chosen: number): void {
    this.index = chosen;
    for (const [index, button] of [...this.root.children].entries()) {
      setAttr(button, "aria-pressed", String(index === chosen));
    }
    for (const listener of this.listeners) listener();
  }
}
