// Where the states of a machine and the ways between them are drawn.
import dagre from "@dagrejs/dagre";
import type { Graph } from "../../../net/protocol";

const CHAR_PX = 6.6;
const CAPITAL_PX = 8;
/** Least width of a state. */
const LEAST_NODE_PX = 72;
/** Room beside the name of a state: the mark of a breakpoint at its left, the sign of the end at its right. */
const BESIDE_NAME_PX = 40;
export const LABEL_CHAR_PX = 6.2;
const NODE_HEIGHT = 26;
/** Height of the label of an edge. */
export const LABEL_HEIGHT_PX = 12;
const LABEL_HEIGHT = LABEL_HEIGHT_PX + 2;
const MARGIN_PX = 2;
/** More labels than this would cover the picture. */
const MANY_EDGES = 40;

export interface Point {
  x: number;
  y: number;
}
export interface Box extends Point {
  width: number;
  height: number;
}
export interface LaidEdge {
  from: number;
  to: number;
  label: string;
  /** All that leads this way, one below the other. */
  about: string;
  /** Its label. */
  text: string;
  points: Point[];
  /** Where the label is; null where there are too many. */
  at: Point | null;
}
export interface Layout {
  left: number;
  top: number;
  width: number;
  height: number;
  nodes: Box[];
  /** Whether a node holds others. */
  holds: boolean[];
  edges: LaidEdge[];
}

/** The edges of the drawing: one line for all transitions of a matrix from one state to another
 * (its table names the events); the guards of a machine are in its table only. */
function drawn(graph: Graph): { from: number; to: number; label: string; text: string; about: string }[] {
  const found = new Map<string, { from: number; to: number; label: string; text: string; about: string }>();
  for (const { from, to, label } of graph.edges) {
    const key = graph.kind === "matrix" ? `${from} ${to}` : `${from} ${to} ${label}`;
    const known = found.get(key);
    const text = graph.kind === "matrix" ? "" : (label.split(" [")[0] ?? label);
    if (known === undefined) found.set(key, { from, to, label, text, about: label });
    else known.about += `\n${label}`;
  }
  // A way from a state to itself says nothing in a drawing without labels.
  return [...found.values()].filter(({ from, to }) => graph.kind !== "matrix" || from !== to);
}

function nameWidth(name: string): number {
  const capitals = name.replace(/[^A-Z_]/g, "").length;
  return CAPITAL_PX * capitals + CHAR_PX * (name.length - capitals);
}

export function layout(graph: Graph): Layout {
  const holds = graph.nodes.map(() => false);
  for (const { parent } of graph.nodes) if (parent !== null) holds[parent] = true;
  const nested = holds.some(Boolean);
  const picture = new dagre.graphlib.Graph({ multigraph: true, compound: nested });
  // The table of a matrix needs the height.
  const rankdir = graph.kind === "matrix" ? "LR" : "TB";
  picture.setGraph({ rankdir, nodesep: 26, ranksep: 16, edgesep: 14, marginx: 8, marginy: 8 });
  for (const [index, node] of graph.nodes.entries()) {
    const width = Math.max(LEAST_NODE_PX, nameWidth(node.name) + BESIDE_NAME_PX);
    picture.setNode(String(index), { width, height: NODE_HEIGHT });
    if (node.parent !== null && node.parent < index) picture.setParent(String(index), String(node.parent));
  }
  const edges = drawn(graph);
  const labelled = edges.length <= MANY_EDGES;
  for (const [index, edge] of edges.entries()) {
    const shown = labelled && edge.text !== "";
    const width = shown ? LABEL_CHAR_PX * edge.text.length + 8 : 0;
    const label = { width, height: shown ? LABEL_HEIGHT : 0, labelpos: "c" };
    picture.setEdge(String(inner(graph, holds, edge.from)), String(inner(graph, holds, edge.to)), label, String(index));
  }
  dagre.layout(picture);
  return fitted({
    width: picture.graph().width ?? 0,
    height: picture.graph().height ?? 0,
    left: 0,
    top: 0,
    holds,
    nodes: graph.nodes.map((_, index) => {
      const { x, y, width, height } = picture.node(String(index));
      return { x, y, width, height };
    }),
    edges: edges.map((edge, index) => {
      const from = String(inner(graph, holds, edge.from));
      const laid = picture.edge(from, String(inner(graph, holds, edge.to)), String(index));
      const at = labelled && laid.x !== undefined && laid.y !== undefined ? { x: laid.x, y: laid.y } : null;
      return { ...edge, points: laid.points ?? [], at: edge.text === "" ? null : at };
    }),
  });
}

/** Ways may lead around the states, out of the size that was reckoned. */
function fitted(found: Layout): Layout {
  const all = found.edges.flatMap(({ points }) => points);
  const [xs, ys] = [all.map(({ x }) => x), all.map(({ y }) => y)];
  const left = Math.min(0, ...xs) - MARGIN_PX;
  const top = Math.min(0, ...ys) - MARGIN_PX;
  const width = Math.max(found.width, ...xs) + MARGIN_PX - left;
  const height = Math.max(found.height, ...ys) + MARGIN_PX - top;
  return { ...found, left, top, width, height };
}

/** The layout takes no edges of boxes: their first part takes their place. */
function inner(graph: Graph, holds: boolean[], node: number): number {
  let at = node;
  while (holds[at]) {
    const part = graph.nodes.findIndex((one) => one.parent === at);
    if (part <= at) break;
    at = part;
  }
  return at;
}
