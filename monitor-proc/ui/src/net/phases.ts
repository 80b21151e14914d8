// The phase at the moment that is shown, and what came after the task was done, from the lanes of the timeline: bar,
// panel and lanes then say the same.
import type { Span } from "./protocol";
import { FLAG } from "./snapshot";
import { RESTS, SAME_S } from "./spans";
import type { Store } from "./store";

function current(store: Store, kind: Span["kind"], until_s: number): Span[] {
  return store.spans.filter((span) => span.kind === kind && span.from_s <= until_s);
}

/** Time up to which the lanes tell of the moment that is shown (s): now is told sooner by lanes than by snapshots. */
function until(store: Store): number {
  const { snapshot, hello } = store;
  const isNow = hello?.live !== false && ((snapshot?.flags ?? 0) & FLAG.notLive) === 0;
  return isNow ? Infinity : (snapshot?.time ?? Infinity);
}

/** As the task spells it: `LIFT`, or of several arms `LEFT_LIFT`. */
export function phaseOf(store: Store): string {
  const spans = current(store, "phase", until(store));
  const newest = [...new Map(spans.map((span) => [span.lane, span])).values()].sort((one, other) => one.from_s - other.from_s);
  if (newest.length === 0) return store.status?.task.phase ?? "";
  const named = newest.filter(({ label }) => label !== "");
  // Of several arms one that works says more than one that rests.
  const span = named.filter(({ label }) => !RESTS.test(label)).at(-1) ?? named.at(-1);
  if (span === undefined) return "";
  const arm = span.lane.replace(/^phase ?/, "");
  return arm === "" ? span.label : `${arm.toUpperCase()}_${span.label}`;
}

export interface AfterDone {
  /** What is done, as the task said it; empty where it said nothing. */
  achieved: string;
  /** Phase in which the task works on; empty while it waits. */
  phase: string;
  /** How often a grip broke or an object was lost since. */
  drops: number;
}

/** What a task that is done does since. */
export function afterDone(store: Store): AfterDone {
  const until_s = until(store);
  const done = current(store, "task", until_s).at(-1);
  const done_s = done?.label === "done" ? done.from_s : Infinity;
  const marks = store.marked.filter((line) => line.mark !== null && line.time_s <= until_s && store.isCurrent(line));
  const since = current(store, "phase", until_s).filter(({ from_s, label }) => from_s > done_s + SAME_S && label !== "");
  const phase = since.length > 0 && !RESTS.test(since.at(-1)?.label ?? "") ? phaseOf(store) : "";
  const drops = marks.filter(({ mark, text, time_s }) => !text.startsWith("object lost") && (mark === "break" || mark === "drop") && time_s > done_s).length;
  // The page's own line of it says no more than that it is done.
  const achieved = marks.filter((line) => line.mark === "done" && !store.own.includes(line)).at(-1)?.text.replace(/^\[\w+\] /, "") ?? "";
  return { achieved, phase, drops };
}
