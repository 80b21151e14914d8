// Lasting faults that the task does not know of: bar, badge, lanes and marks use these words.
import type { LogLine } from "./protocol";
import type { Store } from "./store";

export const OBJECT_LOST = "object lost";
export const NOT_REACHED = "not reached";
/** After a grip was lost, until an arm holds something again. */
export const PICKING_UP = "picking up again";

export type Wrong = typeof OBJECT_LOST | typeof NOT_REACHED | "";

/** From `from_s` on, until the next one, this is wrong. */
export interface WrongFrom {
  from_s: number;
  label: Wrong;
}

/** All states in the order of time; one that continues is told once. */
export function inOrder(states: WrongFrom[]): WrongFrom[] {
  const sorted = [...states].sort((one, other) => one.from_s - other.from_s);
  return sorted.filter(({ label }, index) => label !== (sorted[index - 1]?.label ?? ""));
}

/** The sentence of an object that is lost. */
export function lostText(name: string): string {
  return `object lost: ${name} fell out of the cell`;
}

/** The sentence of one that a device can bring again. */
export function fallenText(name: string): string {
  return `${lostText(name)}; it can be brought again`;
}

/** The mark of the end, by the outcome. */
const END_MARKS: Partial<Record<string, string>> = { done: "done", failed: "fault" };

/** The lines that tell how the state began that lasts at the moment shown: they are marked also where that is out of the window. */
export function lasting(store: Store): LogLine[] {
  const { snapshot, status } = store;
  const until_s = snapshot?.time ?? Infinity;
  const before = store.marked.filter((line) => line.time_s <= until_s && line.mark !== null && store.isCurrent(line));
  const last = (fits: (line: LogLine) => boolean) => before.filter(fits).slice(-1);
  const lost = [...store.lost, ...store.fallen].flatMap((name) => last(({ text }) => text.startsWith(lostText(name))));
  const isAway = store.wrongAt(until_s) === NOT_REACHED;
  const away = isAway ? last(({ mark, text }) => mark === "hand_failed" && text.includes("target not reached")) : [];
  const outcome = status?.task.outcome;
  const end = END_MARKS[outcome ?? ""];
  const ended = end === undefined ? [] : last(({ mark }) => mark === end);
  return [...lost, ...away, ...ended];
}
