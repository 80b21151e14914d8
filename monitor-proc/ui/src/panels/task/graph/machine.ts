// A machine or matrix: its drawing, where the active state and the way taken last are
// highlighted, and under it the table it was drawn from.
import type { Span } from "../../../net/protocol";
import { el, setText, svg } from "../../dom";
import { lastScroll } from "../../last-scroll";
import { breakSpot } from "../breaks/dot";
import { toggleBreak } from "../breaks/state";
import { drawEdge, drawHead, drawLabel } from "./edge";
import { lettersOf } from "./letters";
import { type Box, LABEL_CHAR_PX, LABEL_HEIGHT_PX, type Layout, layout } from "./machine-layout";
import { machineMode } from "./mode";
import { aboutNode, type GraphView, keyOf, type Place } from "./place";
import { liveTable } from "./table";
import { takenOf } from "./taken";
import { type Bounds, Viewport } from "./viewport";

/** The mark of a breakpoint at the left of a name is wider than the sign at its right: so far is the name from the middle. */
const NAME_SHIFT_PX = 2;
/** For this long after a person scrolled the table stays where it is (ms). */
const REST_MS = 5000;
/** Place of the sign of the end, from the right border of a state. */
const SIGN_PX = 8;

/** How the task ended in a state, told without colour. */
const END_SIGNS: Record<string, string> = { S: "✓", F: "✗" };

/** The part of a drawing around a point. */
function around({ x, y, width, height }: Box): Bounds {
  return { left: x - width / 2, top: y - height / 2, width, height };
}

export function machineView(place: Place): GraphView {
  const drawing = new MachineDrawing(place);
  const table = liveTable(place.context.store, place.at, place.graph);
  const label = `Table of ${place.graph.name}`;
  const attrs = { class: "table-box scroll", tabindex: 0, role: "region", "aria-label": label };
  const below = el("div", attrs, table.root);
  const scrolledAt = lastScroll(below);
  const both = place.graph.edges.length > 0 ? [drawing.root, below] : [drawing.root];
  const shown = { graph: [drawing.root], table: [below] }[machineMode.name] ?? both;
  const root = el("div", { class: `machine-pane ${machineMode.name}` }, ...shown);
  const followTable = () => {
    if (performance.now() - scrolledAt() > REST_MS) place.context.pulse.measure(table.follow);
  };
  // After a change of size the active row may be out of sight.
  new ResizeObserver(followTable).observe(root);
  return {
    root,
    show: () => {
      drawing.show();
      table.show();
    },
    follow: () => {
      drawing.follow();
      followTable();
    },
    followTable,
    mark: (found) => drawing.mark(found),
    select: (node) => drawing.select(node),
  };
}

class MachineDrawing {
  private readonly viewport: Viewport;
  private readonly laid: Layout;
  private readonly nodes: SVGGElement[];
  private readonly edges: SVGGElement[];
  private readonly labels: (SVGGElement | null)[];
  private spelled: Span[] | null = null;

  constructor(private readonly place: Place) {
    const { graph } = place;
    this.laid = layout(graph);
    const most = place.name === "large" ? 2 : 1.25;
    this.viewport = new Viewport(`${place.name}/${keyOf(place)}`, `The ${graph.kind} ${graph.name}`, this.laid, most);
    const { defs, head } = drawHead();
    this.edges = this.laid.edges.map((edge) => drawEdge(edge, head));
    this.labels = this.laid.edges.map(drawLabel);
    this.nodes = graph.nodes.map((_, index) => this.node(index));
    // Boxes are behind the edges, these behind their labels, and all behind the states.
    const { holds } = this.laid;
    const boxes = this.nodes.filter((_, index) => holds[index]);
    const states = this.nodes.filter((_, index) => !holds[index]);
    this.viewport.world.classList.add("machine");
    const labels = this.labels.flatMap((label) => label ?? []);
    this.viewport.world.append(defs, ...boxes, ...this.edges, ...labels, ...states);
    this.viewport.onPlaced = (isWhole) => this.hideCut(isWhole);
  }

  /** A name that is cut at the border reads like another one. */
  private hideCut(isWhole: (part: Bounds) => boolean): void {
    for (const [index, node] of this.nodes.entries()) {
      const box = this.laid.nodes[index];
      if (box !== undefined && this.laid.holds[index] !== true) node.classList.toggle("cut", !isWhole(around(box)));
    }
    for (const [index, node] of this.labels.entries()) {
      const { at = null, text = "" } = this.laid.edges[index] ?? {};
      if (at === null) continue;
      const box = { ...at, width: LABEL_CHAR_PX * text.length, height: LABEL_HEIGHT_PX };
      node?.classList.toggle("cut", !isWhole(around(box)));
    }
  }

  /** The lanes and the bar name a phase as the task spells it; the state of that name is spelled alike. */
  private spell(): void {
    const { context, graph } = this.place;
    const { spans } = context.store;
    if (this.spelled === spans) return;
    this.spelled = spans;
    const phases = spans.filter(({ kind }) => kind === "phase");
    const labels = new Map(phases.map(({ label }) => [label.toLowerCase(), label]));
    for (const [index, node] of this.nodes.entries()) {
      const name = graph.nodes[index]?.name ?? "";
      const text = node.querySelector("text");
      if (text !== null) setText(text, labels.get(name.toLowerCase()) ?? name);
    }
  }

  get root(): HTMLElement {
    return this.viewport.root;
  }

  show(): void {
    const { context, at, graph } = this.place;
    const letters = lettersOf(context.store, at);
    for (const [index, node] of this.nodes.entries()) {
      node.dataset.status = letters[index] ?? "I";
      const sign = node.querySelector(".end-sign");
      if (sign !== null) setText(sign, END_SIGNS[letters[index] ?? ""] ?? "");
    }
    this.spell();
    const last = takenOf(context.store, at);
    const { edges } = this.laid;
    const isSame = (edge: { from: number; to: number }) => edge.from === last?.from && edge.to === last.to;
    const named = edges.findIndex((edge) => isSame(edge) && edge.label === last?.label);
    // All ways of a matrix from one state to another are one line.
    const same = edges.findIndex(isSame);
    const taken = named < 0 && graph.kind === "matrix" ? same : named;
    for (const all of [this.edges, this.labels]) {
      for (const [index, edge] of all.entries()) edge?.classList.toggle("last", index === taken);
    }
  }

  /** Keeps the active state in sight. */
  follow(): void {
    const letters = lettersOf(this.place.context.store, this.place.at);
    const at = (letter: string) =>
      this.laid.nodes.findIndex((_, index) => letters[index] === letter && this.laid.holds[index] !== true);
    // The last state of a job that is over runs no more.
    const active = at("R") >= 0 ? at("R") : at("S") >= 0 ? at("S") : at("F");
    const last = takenOf(this.place.context.store, this.place.at)?.from;
    const next = this.laid.edges.flatMap(({ from, to }) => (from === active ? [to] : []));
    const before = this.laid.edges.flatMap(({ from, to }) => (to === active ? [from] : []));
    const all = [...new Set([active, last ?? active, ...next, ...before])];
    this.viewport.watch(all.flatMap((index) => this.laid.nodes[index] ?? []).map(around));
  }

  mark(found: ReadonlySet<number>): void {
    for (const [index, node] of this.nodes.entries()) node.classList.toggle("found", found.has(index));
  }

  select(index: number): void {
    this.choose(index);
    const box = this.laid.nodes[index];
    if (box !== undefined) this.viewport.reveal(around(box));
  }

  private choose(index: number): void {
    for (const [at, node] of this.nodes.entries()) node.classList.toggle("chosen", at === index);
  }

  private node(index: number): SVGGElement {
    const { graph, context, onNode } = this.place;
    const box = this.laid.nodes[index] ?? { x: 0, y: 0, width: 0, height: 0 };
    const isBox = this.laid.holds[index] === true;
    const name = graph.nodes[index]?.name ?? "";
    const [left, top] = [box.x - box.width / 2, box.y - box.height / 2];
    const node = svg(
      "g",
      { class: isBox ? "state holds" : "state", tabindex: 0, role: "button" },
      svg("title", {}, aboutNode(graph, index)),
      svg("rect", { x: left, y: top, width: box.width, height: box.height, rx: 6 }),
      svg("text", { x: box.x + NAME_SHIFT_PX, y: isBox ? top + 12 : box.y + 4 }, name),
      svg("text", { x: left + box.width - SIGN_PX, y: isBox ? top + 12 : box.y + 4, class: "end-sign" }),
      breakSpot(context, name, left + 8, isBox ? top + 9 : box.y),
    );
    const choose = () => {
      this.choose(index);
      onNode(index);
    };
    node.addEventListener("click", choose);
    node.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === "Enter") choose();
      else if (event.key === "b") toggleBreak(context, name);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
    return node;
  }
}
