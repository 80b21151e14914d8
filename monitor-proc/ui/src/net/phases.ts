// The phase at the moment that is shown, and what came after the task was done, from the lanes of the timeline: bar,
// panel and lanes then say the same.
import type { LogLine, Span } from "./protocol";
import { FLAG } from "./snapshot";
import { RESTS } from "./spans";
import type { Store } from "./store";
import { OBJECT_LOST, PICKING_UP } from "./wrong";

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
  const byLane = new Map(spans.map((span) => [span.lane, span]));
  const newest = [...byLane.values()].sort((one, other) => one.from_s - other.from_s);
  if (newest.length === 0) return store.status?.task.phase ?? "";
  const named = newest.filter(({ label }) => label !== "");
  // Of several arms one that works says more than one that rests.
  const span = named.filter(({ label }) => !RESTS.test(label)).at(-1) ?? named.at(-1);
  if (span === undefined) return "";
  const arm = span.lane.replace(/^phase ?/, "");
  return arm === "" ? span.label : `${arm.toUpperCase()}_${span.label}`;
}

export interface AfterDone {
  /** The result, in the words of the task; empty if the task gave none. */
  achieved: string;
  /** Whether it lost its grip since: it works again. */
  isAgain: boolean;
  /** Whether it does not hold the object yet. */
  isPickingUp: boolean;
  /** Phase in which the task works on then; else empty. */
  phase: string;
}

/** Lines of marks that tell of a lost grip; an object that fell out of the cell is not one to be picked up. */
function isLoss({ mark, text }: LogLine): boolean {
  return (mark === "break" || mark === "drop") && !text.startsWith(OBJECT_LOST);
}

/** When a grip was lost, in the history that led to now (s). */
export function lossesOf(store: Store): number[] {
  return store.marked.filter((line) => isLoss(line) && store.isCurrent(line)).map(({ time_s }) => time_s);
}

/** When the task was reset, in the history that led to now (s). */
export function resetsOf(store: Store): number[] {
  const resets = store.marked.filter((line) => line.mark === "reset" && store.isCurrent(line));
  return resets.map(({ time_s }) => time_s).sort((one, other) => one - other);
}

/** Whether a grip was lost before the moment that is shown, and nothing is held since. */
export function isPickingUp(store: Store): boolean {
  const until_s = until(store);
  const lost_s = Math.max(...lossesOf(store).filter((at_s) => at_s <= until_s));
  const runs = current(store, "task", until_s).filter(({ label }) => label === "running");
  const run_s = runs.at(-1)?.from_s ?? -Infinity;
  if (lost_s === -Infinity || lost_s < run_s) return false;
  return !current(store, "grip", until_s).some(({ label, from_s }) => label !== "" && from_s > lost_s);
}

/** What a task that is done does since. */
export function afterDone(store: Store): AfterDone {
  const until_s = until(store);
  const state = current(store, "task", until_s).at(-1)?.label;
  // The lane says `done` of an object that is lost as well, unless its grip was lost before.
  const isDone = store.status?.task.outcome === "done";
  const isPickingUp = isDone && (state === PICKING_UP || state === OBJECT_LOST);
  const isAgain = isPickingUp || (isDone && state === "running");
  const ends = store.marked.filter((line) => line.mark === "done" && line.time_s <= until_s && store.isCurrent(line));
  // The page's own line of it says no more than that it is done.
  const last = ends.filter((line) => !store.own.includes(line)).at(-1);
  const achieved = last?.text.replace(/^\[\w+\] /, "") ?? "";
  return { achieved, isAgain, isPickingUp, phase: isAgain ? phaseOf(store) : "" };
}
