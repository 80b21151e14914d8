// Where a graph is shown, and what a picture of it can do.
import type { Graph } from "../../../net/protocol";
import type { PanelContext } from "../../context";

export interface Place {
  context: PanelContext;
  /** Index of the graph. */
  at: number;
  graph: Graph;
  /** Pictures of one graph in different places keep their own pan and zoom. */
  name: "panel" | "large" | "beside";
  /** A node was chosen. */
  onNode: (node: number) => void;
}

export interface GraphView {
  root: Element;
  /** Shows the newest statuses and the last edge. */
  show: () => void;
  /** Brings the running node into sight. */
  follow: () => void;
  /** Brings the active state into sight in the table alone. */
  followTable?: () => void;
  /** Marks the nodes that were found. */
  mark: (found: ReadonlySet<number>) => void;
  /** Selects a node and brings it into sight. */
  select: (node: number) => void;
}

/** The key under which the settings of a drawing are kept. */
export function keyOf({ context, graph }: Place): string {
  return `${context.store.scene?.demo ?? ""}/${graph.name}`;
}

/** What a node does, in words. */
export function aboutNode(graph: Graph, index: number): string {
  const node = graph.nodes[index];
  return [node?.kind ?? "", node?.detail ?? ""].join("\n").trim();
}
