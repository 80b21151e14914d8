// Where the nodes of a tree are drawn: a column a depth, leaves below each other,
// parents beside the middle of their children.
import type { Graph } from "../../../net/protocol";
import type { Folds } from "./folds";
import { hidden, type Shape, signOf } from "./shape";
import type { Bounds } from "./viewport";

const CHAR_PX = 6.8;
const ROW_PX = 28;
const COLUMN_GAP_PX = 26;
export const NODE_HEIGHT_PX = 22;
/** Places of the breakpoint and of the chevron. */
const ENDS_PX = 34;

export interface TreeBox {
  x: number;
  y: number;
  width: number;
}

export interface TreeLayout extends Bounds {
  /** By node, null for one that is within a collapsed one; x is the left end, y the middle. */
  boxes: (TreeBox | null)[];
}

/** The caption of a node. */
export function captionOf(graph: Graph, index: number): string {
  const { name = "?", kind = "" } = graph.nodes[index] ?? {};
  return `${signOf(kind)} ${name}`.trim();
}

export function treeLayout(graph: Graph, shape: Shape, folds: Folds): TreeLayout {
  const away = hidden(graph, shape, folds);
  const widths = graph.nodes.map((_, index) => CHAR_PX * captionOf(graph, index).length + ENDS_PX);
  const columns: number[] = [];
  for (const [index, width] of widths.entries()) {
    const depth = shape.depth[index] ?? 0;
    if (away[index] !== true) columns[depth] = Math.max(columns[depth] ?? 0, width);
  }
  const before = (depth: number) => columns.slice(0, depth).reduce((sum, width) => sum + width + COLUMN_GAP_PX, 0);
  const lefts = columns.map((_, depth) => before(depth));
  const boxes: (TreeBox | null)[] = graph.nodes.map(() => null);
  let rows = 0;
  const put = (index: number): number => {
    const shown = (shape.children[index] ?? []).filter((child) => away[child] !== true);
    const ys = shown.map(put);
    const y = ys.length === 0 ? ROW_PX * (0.5 + rows++) : ((ys[0] ?? 0) + (ys.at(-1) ?? 0)) / 2;
    boxes[index] = { x: lefts[shape.depth[index] ?? 0] ?? 0, y, width: widths[index] ?? 0 };
    return y;
  };
  for (const [index, parent] of shape.parents.entries()) if (parent === null) put(index);
  const width = (lefts.at(-1) ?? 0) + (columns.at(-1) ?? 0);
  return { left: 0, top: 0, width: Math.max(width, 1), height: Math.max(ROW_PX * rows, 1), boxes };
}
