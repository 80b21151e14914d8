// The place of the graph: a tree or a machine with its tools, in the panel or large.
import type { PanelContext } from "../../context";
import { el, plainButton, setAttr, spacer } from "../../dom";
import { icon } from "../../icons";
import type { GraphChoice } from "../choice";
import { NodeDetail } from "../node-detail";
import { Finder } from "./find";
import { machineView } from "./machine";
import { machineMode, treeMode } from "./mode";
import { Outline } from "./outline";
import type { GraphView, Place } from "./place";
import { type Running, runningNow } from "./running";
import { type Strip, stateStrip } from "./strip";
import { TreeDrawing } from "./tree-drawing";

function makeView(place: Place): GraphView {
  if (place.graph.kind !== "tree") return machineView(place);
  return treeMode.name === "tree" ? new TreeDrawing(place) : new Outline(place);
}

/** One graph with its tools. */
class Pane {
  readonly body = el("div", { class: "graph-body" });
  readonly tools = el("div", { class: "graph-tools row" });
  view: GraphView | null = null;
  private readonly finder: Finder;
  private readonly tree = treeMode.buttons();
  private readonly machine = machineMode.buttons();
  private readonly strip: Strip;
  private readonly running: Running;

  constructor(
    private readonly context: PanelContext,
    private readonly index: () => number,
    private readonly name: Place["name"],
    private readonly onNode: (node: number) => void,
    extra: HTMLElement[],
  ) {
    const graph = () => context.store.graphs[index()];
    this.finder = new Finder(graph, () => this.view);
    this.strip = stateStrip(context);
    this.running = runningNow(context.store, index, (node) => this.view?.select(node));
    this.tools.append(this.finder.field, this.finder.count, this.tree, this.machine, spacer(), ...extra);
  }

  get parts(): HTMLElement[] {
    return [this.tools, this.strip.root, this.running.root, this.body];
  }

  /** Listens until the function that is returned is called. */
  listen(root: HTMLElement, draw: () => void): () => void {
    const off = [
      this.finder.listen(root),
      this.context.store.on("lanes", () => this.strip.show()),
      treeMode.on(draw),
      machineMode.on(draw),
    ];
    return () => {
      for (const one of off) one();
    };
  }

  draw(empty: HTMLElement): void {
    const { context, name, onNode } = this;
    const at = this.index();
    const graph = context.store.graphs[at];
    this.view = graph === undefined ? null : makeView({ context, at, graph, name, onNode });
    this.body.replaceChildren(this.view?.root ?? empty);
    // Classes instead of `:has`, which looks through a tree of thousands of nodes at every change.
    const has = (selector: string) => this.body.querySelector(selector) !== null;
    this.body.classList.toggle("with-drawing", has(".viewport"));
    this.body.parentElement?.classList.toggle("with-table", has(".live-table"));
    this.tools.hidden = this.view === null;
    const isTree = graph?.kind === "tree";
    this.tree.hidden = !isTree;
    this.machine.hidden = isTree;
    this.strip.root.classList.toggle("none", isTree);
    this.running.root.hidden = !isTree;
    this.finder.refresh();
    this.show();
  }

  show(): void {
    this.view?.show();
    this.running.show();
  }
}

export function graphPane(context: PanelContext, choice: GraphChoice, onNode: (node: number) => void): HTMLElement {
  const empty = el("p", { class: "dim hint" }, "The task has not shown its graph yet.");
  const about = "Show the graph large";
  const attrs = { class: "button icon-only quiet grow", title: about, "aria-label": about };
  const grow = plainButton(attrs, () => enlarge(context, choice.index), icon("grow"));
  const pane = new Pane(context, () => choice.index, "panel", onNode, [grow]);
  const root = el("div", { class: "graph-pane" }, ...pane.parts);
  const draw = () => {
    pane.draw(empty);
    pane.view?.follow();
  };
  choice.on(draw);
  pane.listen(root, draw);
  let changed = false;
  context.store.on("graph", (index) => {
    if (index === choice.index) changed = true;
  });
  // The lane of the phases may tell the last transition.
  context.store.on("lanes", () => {
    changed = true;
  });
  // The last state of a job that failed is shown as failed.
  let outcome = "";
  context.store.on("status", ({ task }) => {
    if (task.outcome !== outcome) changed = true;
    outcome = task.outcome;
  });
  context.pulse.add(root, () => {
    if (!changed) return;
    changed = false;
    pane.show();
    // A drawing under the pointer stays: a person may be reading it. A table knows when it was scrolled.
    if (root.matches(":hover, :focus-within")) pane.view?.followTable?.();
    else pane.view?.follow();
  });
  draw();
  return root;
}

function enlarge(context: PanelContext, index: number): void {
  const { store } = context;
  const detail = new NodeDetail(context, () => index);
  const close = plainButton({}, () => dialog.close(), "Close");
  const show = (node: number) => detail.show(node);
  const pane = new Pane(context, () => index, "large", show, []);
  const title = el("h2", {}, store.graphs[index]?.name ?? "");
  const dialog = el("dialog", { class: "large-graph" }, el("header", {}, title, close), ...pane.parts, detail.root);
  setAttr(dialog, "aria-label", `Graph ${store.graphs[index]?.name ?? ""}`);
  const draw = () => pane.draw(el("p", {}));
  const off = [
    store.on("graph", (changed) => changed === index && pane.show()),
    store.on("graphs", () => dialog.close()),
    pane.listen(dialog, draw),
  ];
  dialog.addEventListener("close", () => {
    for (const one of off) one();
    dialog.remove();
  });
  document.body.append(dialog);
  draw();
  dialog.showModal();
}
