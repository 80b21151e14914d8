// A behaviour tree as a drawing, from left to right; subtrees collapse.
import { setAttr, svg } from "../../dom";
import { breakSpot } from "../breaks/dot";
import { toggleBreak } from "../breaks/state";
import { type Folds, foldsOf } from "./folds";
import { aboutNode, type GraphView, keyOf, type Place } from "./place";
import { below, runningBelow, type Shape, shapeOf, unfold } from "./shape";
import { captionOf, NODE_HEIGHT_PX, type TreeBox, type TreeLayout, treeLayout } from "./tree-layout";
import { type Bounds, Viewport } from "./viewport";

export class TreeDrawing implements GraphView {
  private readonly viewport: Viewport;
  private readonly shape: Shape;
  private readonly folds: Folds;
  private layout: TreeLayout;
  private nodes = new Map<number, SVGGElement>();
  private edges = new Map<number, SVGPathElement>();
  private found: ReadonlySet<number> = new Set();
  private chosen = 0;

  constructor(private readonly place: Place) {
    const { graph } = place;
    this.shape = shapeOf(graph);
    this.folds = foldsOf(keyOf(place), graph, this.shape);
    this.layout = treeLayout(graph, this.shape, this.folds);
    const most = place.name === "large" ? 1.6 : 1.25;
    this.viewport = new Viewport(`${place.name}/${keyOf(place)}/tree`, `The tree ${graph.name}`, this.layout, most);
    this.draw();
    const off = this.folds.on(() => {
      if (!this.root.isConnected) return off();
      const focused = this.root.contains(document.activeElement) && document.activeElement !== this.root;
      this.layout = treeLayout(graph, this.shape, this.folds);
      this.draw();
      this.show();
      this.viewport.resize(this.layout);
      if (focused) this.nodes.get(this.chosen)?.focus();
    });
  }

  get root(): HTMLElement {
    return this.viewport.root;
  }

  show(): void {
    const { context, at, graph } = this.place;
    const letters = context.store.letters[at] ?? "";
    const running = runningBelow(this.shape, letters);
    for (const [index, node] of this.nodes) {
      node.dataset.status = letters[index] ?? "I";
      const shut = this.folds.has(graph.nodes[index]?.id ?? "");
      const runs = shut ? (running[index] ?? null) : null;
      const inside = node.querySelector(".inside");
      const words = runs === null ? "" : `▶ ${graph.nodes[runs]?.name ?? ""}`;
      if (inside !== null && inside.textContent !== words) inside.textContent = words;
      const edge = this.edges.get(index);
      if (edge !== undefined) edge.dataset.status = letters[index] ?? "I";
    }
  }

  follow(): void {
    // What runs within a collapsed node is told at that node.
    let at: number | null = (this.place.context.store.letters[this.place.at] ?? "").lastIndexOf("R");
    while (at !== null && this.layout.boxes[at] == null) at = this.shape.parents[at] ?? null;
    const box = at === null ? null : this.layout.boxes[at];
    if (box != null) this.viewport.watch([around(box)]);
  }

  mark(found: ReadonlySet<number>): void {
    this.found = found;
    for (const [index, node] of this.nodes) node.classList.toggle("found", found.has(index));
  }

  select(node: number): void {
    unfold(this.place.graph, this.shape, this.folds, node);
    this.choose(node);
    const box = this.layout.boxes[node];
    if (box != null) this.viewport.reveal(around(box));
  }

  private choose(index: number): void {
    const before = this.nodes.get(this.chosen);
    before?.classList.remove("chosen");
    before?.setAttribute("tabindex", "-1");
    this.chosen = index;
    const next = this.nodes.get(index);
    next?.classList.add("chosen");
    next?.setAttribute("tabindex", "0");
  }

  private draw(): void {
    this.nodes = new Map();
    this.edges = new Map();
    for (const [index, box] of this.layout.boxes.entries()) {
      if (box === null) continue;
      this.nodes.set(index, this.node(index, box));
      const parent = this.shape.parents[index] ?? null;
      const from = parent === null ? null : (this.layout.boxes[parent] ?? null);
      if (from !== null) this.edges.set(index, edge(from, box));
    }
    this.viewport.world.replaceChildren(...this.edges.values(), ...this.nodes.values());
    if (!this.nodes.has(this.chosen)) this.chosen = 0;
    this.nodes.get(this.chosen)?.setAttribute("tabindex", "0");
    this.mark(this.found);
  }

  private node(index: number, { x, y, width }: TreeBox): SVGGElement {
    const { graph, context } = this.place;
    const { id = "", name = "" } = graph.nodes[index] ?? {};
    const isParent = (this.shape.children[index] ?? []).length > 0;
    const attrs = { class: index === this.chosen ? "leaf chosen" : "leaf", tabindex: -1, role: "button" };
    const node = svg(
      "g",
      attrs,
      svg("title", {}, aboutNode(graph, index)),
      svg("rect", { x, y: y - NODE_HEIGHT_PX / 2, width, height: NODE_HEIGHT_PX, rx: 5 }),
      breakSpot(context, name, x + 10, y),
      svg("text", { x: x + 20, y: y + 4 }, captionOf(graph, index)),
    );
    setAttr(node, "aria-label", name);
    if (isParent) node.append(...this.chevron(index, id, x + width, y));
    node.addEventListener("click", () => {
      this.choose(index);
      this.place.onNode(index);
    });
    node.addEventListener("dblclick", () => isParent && this.folds.toggle(id));
    node.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.place.onNode(index);
      else if (event.key === "b") toggleBreak(context, name);
      else if (event.key === " " && isParent) this.folds.toggle(id);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
    return node;
  }

  /** The handle of a subtree, with a summary if it is collapsed. */
  private chevron(index: number, id: string, x: number, y: number): SVGElement[] {
    const shut = this.folds.has(id);
    const handle = svg(
      "g",
      { class: "handle" },
      svg("title", {}, shut ? "Expand" : "Collapse"),
      svg("circle", { cx: x, cy: y, r: 7 }),
      svg("path", { d: shut ? `M${x - 3},${y}h6M${x},${y - 3}v6` : `M${x - 3},${y}h6` }),
    );
    handle.addEventListener("click", (event) => {
      event.stopPropagation();
      this.choose(index);
      this.folds.toggle(id);
    });
    handle.addEventListener("dblclick", (event) => event.stopPropagation());
    if (!shut) return [handle];
    const count = svg("text", { x: x + 12, y: y + 4, class: "count" }, `${below(this.shape, index).length} `);
    count.append(svg("tspan", { class: "inside" }));
    return [handle, count];
  }
}

/** The part of the drawing that a node takes. */
function around({ x, y, width }: TreeBox): Bounds {
  return { left: x, top: y - NODE_HEIGHT_PX / 2, width, height: NODE_HEIGHT_PX };
}

/** A line from the end of a parent to the beginning of its child. */
function edge(from: TreeBox, to: TreeBox): SVGPathElement {
  const start = from.x + from.width + 7;
  const middle = to.x - 9;
  return svg("path", { class: "branch", d: `M${start},${from.y}H${middle}V${to.y}H${to.x}` });
}
