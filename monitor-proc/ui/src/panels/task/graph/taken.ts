// The transition that led to the current state of a machine.
import type { Graph } from "../../../net/protocol";
import type { Store } from "../../../net/store";

/** The last transition; undefined where it did not lead to the current state, as after a reset. */
export function takenOf(store: Store, at: number): Graph["edges"][number] | undefined {
  const edge = store.edges[at];
  const letters = store.letters[at] ?? "";
  return edge !== undefined && (letters[edge.to] ?? "I") !== "I" ? edge : undefined;
}
