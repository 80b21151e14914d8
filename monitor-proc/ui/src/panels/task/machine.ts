// A machine or matrix as a drawing: the active state and the way taken last
// stand out.
import type { Store } from "../../net/store";
import { el, reveal, setAttr, svg } from "../dom";
import { layout, type LaidEdge, type Point } from "./layout";
import { liveTable } from "./table";
import type { GraphView } from "./tree";

let drawings = 0;

/** A smooth line through the corners that the layout gave. */
function curve(points: Point[]): string {
  const [first, ...rest] = points;
  if (first === undefined) return "";
  let path = `M${first.x},${first.y}`;
  for (let i = 0; i < rest.length - 1; i++) {
    const corner = rest[i];
    const next = rest[i + 1];
    if (corner === undefined || next === undefined) break;
    const last = i === rest.length - 2;
    const x = last ? next.x : (corner.x + next.x) / 2;
    const y = last ? next.y : (corner.y + next.y) / 2;
    path += `Q${corner.x},${corner.y} ${x},${y}`;
  }
  if (rest.length === 1) path += `L${rest[0]?.x},${rest[0]?.y}`;
  return path;
}

function drawEdge(edge: LaidEdge, head: string): SVGGElement {
  const path = svg("path", { d: curve(edge.points), "marker-end": `url(#${head})`, fill: "none" });
  const node = svg("g", { class: "edge" }, svg("title", {}, edge.about), path);
  if (edge.at !== null) {
    node.append(svg("text", { x: edge.at.x, y: edge.at.y + 3, class: "edge-label" }, edge.text));
  }
  return node;
}

/** The drawing, and under it the table it was drawn from. */
export function machineView(store: Store, at: number, onNode: (node: number) => void): GraphView {
  const drawn = drawing(store, at, onNode);
  const graph = store.graphs[at];
  if (graph === undefined) return drawn;
  const table = liveTable(store, at, graph);
  const show = () => {
    drawn.show();
    table.show();
  };
  return { root: el("div", { class: "machine-pane" }, drawn.root, table.root), show, follow: drawn.follow };
}

function drawing(store: Store, at: number, onNode: (node: number) => void): GraphView {
  const graph = store.graphs[at];
  const root = svg("svg", { class: "machine", role: "group" });
  if (graph === undefined) return { root, show: () => {}, follow: () => {} };
  const { left, top, width, height, nodes, holds, edges } = layout(graph);
  setAttr(root, "viewBox", `${left} ${top} ${width} ${height}`);
  root.style.setProperty("--width", `${width}px`);
  root.style.setProperty("--height", `${height}px`);
  setAttr(root, "aria-label", `The ${graph.kind} ${graph.name}`);
  const head = `head-${++drawings}`;
  const marker = { id: head, viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 8, markerHeight: 8, markerUnits: "userSpaceOnUse" };
  const arrow = svg("path", { d: "M0,0.6L8,4L0,7.4z", class: "arrow" });
  root.append(svg("defs", {}, svg("marker", { ...marker, orient: "auto-start-reverse" }, arrow)));

  const drawnEdges = edges.map((edge) => drawEdge(edge, head));
  const drawnNodes = nodes.map((box, index) => {
    const node = graph.nodes[index];
    const corner = { x: box.x - box.width / 2, y: box.y - box.height / 2 };
    const rect = svg("rect", { ...corner, width: box.width, height: box.height, rx: 6 });
    const y = holds[index] ? corner.y + 12 : box.y + 4;
    const text = svg("text", { x: box.x, y }, node?.name ?? "");
    const attrs = { class: holds[index] ? "state holds" : "state", tabindex: 0, role: "button" };
    const about = svg("title", {}, [node?.kind ?? "", node?.detail ?? ""].join("\n").trim());
    const drawn = svg("g", attrs, about, rect, text);
    drawn.addEventListener("click", () => onNode(index));
    drawn.addEventListener("keydown", (event) => {
      if (event.key === "Enter") onNode(index);
    });
    return drawn;
  });
  // Boxes lie below, then ways, then states.
  root.append(...drawnNodes.filter((_, index) => holds[index]));
  root.append(...drawnEdges);
  root.append(...drawnNodes.filter((_, index) => !holds[index]));

  let active: Element | undefined;
  const show = () => {
    const letters = store.letters[at] ?? "";
    for (const [index, node] of drawnNodes.entries()) {
      const letter = letters[index] ?? "I";
      node.dataset.status = letter;
      if (letter === "R" && !holds[index]) active = node;
    }
    const last = store.edges[at];
    const same = (edge: LaidEdge) => last !== undefined && edge.from === last.from && edge.to === last.to;
    const named = edges.findIndex((edge) => same(edge) && edge.label === last?.label);
    // All ways of a matrix from one state to another are one line.
    const taken = named < 0 && graph.kind === "matrix" ? edges.findIndex(same) : named;
    for (const [index, edge] of drawnEdges.entries()) edge.classList.toggle("last", index === taken);
  };
  return { root, show, follow: () => reveal(root.closest(".graph-body"), active) };
}
