// The statuses of a graph's nodes as they are shown.
import { afterDone } from "../../../net/phases";
import type { Graph } from "../../../net/protocol";
import type { Store } from "../../../net/store";

/** A letter a node; a machine or matrix stays in its last state, which has succeeded or failed when the task has ended. */
export function lettersOf(store: Store, at: number): string {
  const letters = store.letters[at] ?? "";
  if (store.graphs[at]?.kind === "tree") return letters;
  const outcome = store.status?.task.outcome;
  if (outcome === "failed") return letters.replaceAll("R", "F");
  return outcome === "done" && afterDone(store).phase === "" ? letters.replaceAll("R", "S") : letters;
}

/** The transition that led to the current state; undefined where that state was not entered by one. */
export function takenOf(store: Store, at: number): Store["edges"][number] {
  const edge = store.edges[at];
  const letter = edge === undefined ? "" : (store.letters[at]?.[edge.to] ?? "");
  return letter === "" || letter === "I" ? undefined : edge;
}

/** Whether a task that is done has its end in a state that leads on: nothing comes next, so that it is not shown as active. */
export function isPassed(graph: Graph, letters: string, index: number): boolean {
  return letters[index] === "S" && graph.edges.some(({ from }) => from === index);
}

/** The letter of a state for the ways out of it: none of them is next when the task is done. */
export function wayOut(letter: string | undefined): string {
  return letter === undefined || letter === "S" ? "I" : letter;
}
