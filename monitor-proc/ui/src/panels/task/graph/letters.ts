// The statuses of a graph's nodes as they are shown.
import { afterDone } from "../../../net/phases";
import type { Store } from "../../../net/store";

/** A letter a node; a machine or matrix stays in its last state, which has succeeded or failed when the task has ended. */
export function lettersOf(store: Store, at: number): string {
  const letters = store.letters[at] ?? "";
  if (store.graphs[at]?.kind === "tree") return letters;
  const outcome = store.status?.task.outcome;
  if (outcome === "failed") return letters.replaceAll("R", "F");
  return outcome === "done" && afterDone(store).phase === "" ? letters.replaceAll("R", "S") : letters;
}

/** The letter of a state for the ways out of it: none of them is next when the task is done. */
export function wayOut(letter: string | undefined): string {
  return letter === undefined || letter === "S" ? "I" : letter;
}
