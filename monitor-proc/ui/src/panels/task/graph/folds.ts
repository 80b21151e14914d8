// Which subtrees are collapsed, remembered for every picture of the same tree.
import type { Graph } from "../../../net/protocol";
import type { Shape } from "./shape";

export class Folds {
  private readonly shut = new Set<string>();
  private readonly listeners = new Set<() => void>();

  has(id: string): boolean {
    return this.shut.has(id);
  }

  /** Calls `listener` when a subtree is collapsed or expanded. */
  on(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  toggle(id: string): void {
    this.set(id, !this.shut.has(id));
  }

  set(id: string, shut: boolean): void {
    if (shut === this.shut.has(id)) return;
    if (shut) this.shut.add(id);
    else this.shut.delete(id);
    for (const listener of [...this.listeners]) listener();
  }
}

const all = new Map<string, Folds>();

/** More nodes than these are not looked over at first sight: the deepest subtrees of a larger graph are collapsed. */
const FIRST_SHOWN = 300;

/** The folds of `graph`, remembered by `key`. */
export function foldsOf(key: string, graph: Graph, shape: Shape): Folds {
  let known = all.get(key);
  if (known === undefined) {
    known = new Folds();
    all.set(key, known);
    for (const node of deepSubtrees(shape)) known.set(graph.nodes[node]?.id ?? "", true);
  }
  return known;
}

/** The parents at the depth below which the graph has more than `FIRST_SHOWN` nodes. */
function deepSubtrees({ children, depth }: Shape): number[] {
  if (depth.length <= FIRST_SHOWN) return [];
  const atDepth: number[] = [];
  for (const level of depth) atDepth[level] = (atDepth[level] ?? 0) + 1;
  let last = 0;
  for (let shown = atDepth[0] ?? 0; last + 1 < atDepth.length; last += 1) {
    shown += atDepth[last + 1] ?? 0;
    if (shown > FIRST_SHOWN) break;
  }
  return depth.flatMap((level, node) => (level === last && (children[node] ?? []).length > 0 ? [node] : []));
}
