// Where the states of a machine and the ways between them are drawn.
import dagre from "@dagrejs/dagre";
import type { Graph } from "../../net/protocol";

const CHAR_PX = 6.6;
const LABEL_CHAR_PX = 5.2;
const NODE_HEIGHT = 26;
const LABEL_HEIGHT = 12;
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
  points: Point[];
  /** Where the label stands; null where there are too many. */
  at: Point | null;
}
export interface Layout {
  width: number;
  height: number;
  nodes: Box[];
  /** Whether a node holds others. */
  holds: boolean[];
  edges: LaidEdge[];
}

export function layout(graph: Graph): Layout {
  const holds = graph.nodes.map(() => false);
  for (const { parent } of graph.nodes) if (parent !== null) holds[parent] = true;
  const nested = holds.some(Boolean);
  const picture = new dagre.graphlib.Graph({ multigraph: true, compound: nested });
  picture.setGraph({ rankdir: "TB", nodesep: 26, ranksep: 22, edgesep: 14, marginx: 8, marginy: 8 });
  for (const [index, node] of graph.nodes.entries()) {
    const width = Math.max(64, CHAR_PX * node.name.length + 24);
    picture.setNode(String(index), { width, height: NODE_HEIGHT });
    if (node.parent !== null && node.parent < index) picture.setParent(String(index), String(node.parent));
  }
  const labelled = graph.edges.length <= MANY_EDGES;
  for (const [index, edge] of graph.edges.entries()) {
    const width = labelled ? LABEL_CHAR_PX * edge.label.length + 8 : 0;
    const label = { width, height: labelled ? LABEL_HEIGHT : 0, labelpos: "c" };
    picture.setEdge(String(inner(graph, holds, edge.from)), String(inner(graph, holds, edge.to)), label, String(index));
  }
  dagre.layout(picture);
  const size = picture.graph();
  return {
    width: size.width ?? 0,
    height: size.height ?? 0,
    holds,
    nodes: graph.nodes.map((_, index) => {
      const { x, y, width, height } = picture.node(String(index));
      return { x, y, width, height };
    }),
    edges: graph.edges.map((edge, index) => {
      const from = String(inner(graph, holds, edge.from));
      const laid = picture.edge(from, String(inner(graph, holds, edge.to)), String(index));
      const at = labelled && laid.x !== undefined && laid.y !== undefined ? { x: laid.x, y: laid.y } : null;
      return { ...edge, points: laid.points ?? [], at };
    }),
  };
}

/** The layout takes no edges of boxes: their first part stands in. */
function inner(graph: Graph, holds: boolean[], node: number): number {
  let at = node;
  while (holds[at]) {
    const part = graph.nodes.findIndex((one) => one.parent === at);
    if (part <= at) break;
    at = part;
  }
  return at;
}
