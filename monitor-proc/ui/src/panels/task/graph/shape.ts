// Which node of a tree is below which.
import type { Graph } from "../../../net/protocol";
import type { Folds } from "./folds";

/** Signs of the composites, as on the command line. */
const SIGNS: Record<string, string> = { sequence: "→", selector: "?", parallel: "⇉" };

/** The sign of a kind of node, or an empty text. */
export function signOf(kind: string): string {
  return SIGNS[kind.toLowerCase()] ?? "";
}

export interface Shape {
  children: number[][];
  depth: number[];
  /** Parent by node; null for a root. */
  parents: (number | null)[];
}

/** Parents come before their children; a node that breaks this is a root. */
export function shapeOf(graph: Graph): Shape {
  const parents = graph.nodes.map(({ parent }, index) => (parent !== null && parent < index ? parent : null));
  const children: number[][] = graph.nodes.map(() => []);
  const depth: number[] = [];
  for (const [index, parent] of parents.entries()) {
    depth.push(parent === null ? 0 : (depth[parent] ?? 0) + 1);
    if (parent !== null) children[parent]?.push(index);
  }
  return { children, depth, parents };
}

/** Whether each node is within a collapsed one. */
export function hidden(graph: Graph, { parents }: Shape, folds: Folds): boolean[] {
  const all: boolean[] = [];
  for (const parent of parents) {
    all.push(parent !== null && (all[parent] === true || folds.has(graph.nodes[parent]?.id ?? "")));
  }
  return all;
}

/** All nodes below `node`. */
export function below(shape: Shape, node: number): number[] {
  return (shape.children[node] ?? []).flatMap((child) => [child, ...below(shape, child)]);
}

/** By node, the last node below it that runs, or null. */
export function runningBelow({ parents }: Shape, letters: string): (number | null)[] {
  const last: (number | null)[] = parents.map(() => null);
  for (let node = parents.length - 1; node >= 0; node -= 1) {
    const runs = last[node] ?? (letters[node] === "R" ? node : null);
    const parent = parents[node] ?? null;
    if (runs !== null && parent !== null && (last[parent] ?? -1) < runs) last[parent] = runs;
  }
  return last;
}

/** Expands what hides `node`. */
export function unfold(graph: Graph, { parents }: Shape, folds: Folds, node: number): void {
  for (let at = parents[node] ?? null; at !== null; at = parents[at] ?? null) {
    folds.set(graph.nodes[at]?.id ?? "", false);
  }
}
