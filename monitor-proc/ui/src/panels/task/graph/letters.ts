// The statuses of a graph's nodes as they are shown.
import type { Store } from "../../../net/store";

/** A letter a node; a machine or matrix stays in its last state, which is no normal one where the task failed. */
export function lettersOf(store: Store, at: number): string {
  const letters = store.letters[at] ?? "";
  const isTree = store.graphs[at]?.kind === "tree";
  return !isTree && store.status?.task.outcome === "failed" ? letters.replaceAll("R", "F") : letters;
}
