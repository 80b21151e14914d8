// The place of the graph: a tree or a machine, in the panel or large.
import type { Desk } from "../desk";
import { el } from "../dom";
import { icon } from "../icons";
import type { GraphChoice } from "./choice";
import { machineView } from "./machine";
import { type GraphView, treeView } from "./tree";

export function graphPane(desk: Desk, choice: GraphChoice, onNode: (node: number) => void): HTMLElement {
  const empty = el("p", { class: "dim hint" }, "The task has not shown its graph yet.");
  const body = el("div", { class: "graph-body" }, empty);
  const grow = el("button", { type: "button", class: "button icon-only quiet grow", title: "Show the graph large" });
  grow.setAttribute("aria-label", "Show the graph large");
  grow.append(icon("grow"));
  const root = el("div", { class: "graph-pane" }, body, grow);
  grow.addEventListener("click", () => enlarge(desk, choice.index, onNode));

  let view: GraphView | null = null;
  const draw = () => {
    view = makeView(desk, choice.index, onNode);
    body.replaceChildren(view?.root ?? empty);
    grow.hidden = view === null;
    view?.show();
    view?.follow();
  };
  choice.on(draw);
  desk.store.on("graph", (index) => {
    if (index !== choice.index) return;
    view?.show();
    // Whoever reads is not led away.
    if (!root.matches(":hover, :focus-within") && root.checkVisibility()) view?.follow();
  });
  draw();
  return root;
}

/** A picture of graph `index`, or null where there is none. */
export function makeView(desk: Desk, index: number, onNode: (node: number) => void): GraphView | null {
  const graph = desk.store.graphs[index];
  if (graph === undefined) return null;
  return graph.kind === "tree"
    ? treeView(desk.store, desk.pulse, index, onNode)
    : machineView(desk.store, index, onNode);
}

function enlarge(desk: Desk, index: number, onNode: (node: number) => void): void {
  const view = makeView(desk, index, onNode);
  if (view === null) return;
  const close = el("button", { type: "button", class: "button" }, "Close");
  const title = el("h2", {}, desk.store.graphs[index]?.name ?? "");
  const dialog = el("dialog", { class: "large-graph" }, el("header", {}, title, close), el("div", { class: "graph-body" }, view.root));
  close.addEventListener("click", () => dialog.close());
  const off = desk.store.on("graph", (changed) => changed === index && view.show());
  const gone = desk.store.on("graphs", () => dialog.close());
  dialog.addEventListener("close", () => {
    off();
    gone();
    dialog.remove();
  });
  document.body.append(dialog);
  view.show();
  dialog.showModal();
}
