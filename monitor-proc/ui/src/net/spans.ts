// The spans of the lanes as they are shown: beside those that were told, that a phase ends with its task, and what is
// wrong though the task does not know of it.
import type { Span } from "./protocol";
import { NOT_REACHED, type WrongFrom } from "./wrong";

/** Phases in which an arm waits, and works no more. */
export const RESTS = /(^|_)(done|rest|home|idle|standby|ready)$/i;
/** What begins so soon after the end of a task is part of the same decision (s). */
export const SAME_S = 0.05;

/** Whether a span is of the history that led to now. */
type IsCurrent = (line: { epoch: number | null; time_s: number }) => boolean;

export class ShownSpans {
  private from: unknown[] = [];
  private all: Span[] = [];
  /** What is added has one identity: its bar is drawn once. */
  private made = new Map<string, Span>();

  /** The spans of the current history, oldest first; the same list until something changed. */
  of(lanes: Span[], wrong: WrongFrom[], timeline: unknown, isCurrent: IsCurrent): Span[] {
    const from = [lanes, wrong, timeline];
    if (from.every((one, index) => one === this.from[index])) return this.all;
    this.from = from;
    const known = this.made;
    this.made = new Map();
    const now = lanes.filter((span) => isCurrent({ epoch: span.epoch, time_s: span.from_s }));
    const add = (like: Span, change: Partial<Span>): Span => {
      const span = { ...like, ...change };
      const key = JSON.stringify(span);
      const one = known.get(key) ?? span;
      this.made.set(key, one);
      return one;
    };
    const names = [...new Set(now.map(({ lane }) => lane))];
    const outcome = now.filter(({ kind }) => kind === "task");
    const shown = names.flatMap((name) => {
      const lane = now.filter((span) => span.lane === name);
      const kind = lane[0]?.kind;
      if (kind === "phase") return withDone(lane, outcome, add);
      return kind === "task" ? withStates(lane, wrong, add) : lane;
    });
    shown.sort((one, other) => one.from_s - other.from_s);
    const isSame = shown.length === this.all.length && shown.every((span, index) => span === this.all[index]);
    if (!isSame) this.all = shown;
    return this.all;
  }
}

type Add = (like: Span, change: Partial<Span>) => Span;

/** A phase ends when the task is done, unless the next one began or the arm rests. */
function withDone(lane: Span[], outcome: Span[], add: Add): Span[] {
  const ends = outcome.filter(({ label }) => label === "done");
  return lane.flatMap((span, index) => {
    const next_s = lane[index + 1]?.from_s ?? Infinity;
    const end = ends.find(({ from_s }) => from_s >= span.from_s - SAME_S && from_s + SAME_S < next_s);
    if (end === undefined || span.label === "" || RESTS.test(span.label)) return [span];
    const label = /[a-z]/.test(span.label) ? "done" : "DONE";
    const done = add(span, { from_s: Math.max(end.from_s, span.from_s), epoch: end.epoch, label });
    return end.from_s <= span.from_s ? [done] : [span, done];
  });
}

/** A task that runs and has lost an object, or does not reach its target. */
function withStates(lane: Span[], wrong: WrongFrom[], add: Add): Span[] {
  return lane.flatMap((span, index) => {
    // The end of a task says more.
    if (span.label === "" || span.label === "done" || span.label === "failed") return [span];
    const next_s = lane[index + 1]?.from_s ?? Infinity;
    const state = (from_s: number, label: string): Span => {
      const isWrong = label !== "" && (label !== NOT_REACHED || span.label === "running");
      if (!isWrong && from_s === span.from_s) return span;
      return add(span, isWrong ? { from_s, label, tone: "bad" } : { from_s });
    };
    const before = wrong.filter(({ from_s }) => from_s <= span.from_s).at(-1)?.label ?? "";
    const within = wrong.filter(({ from_s }) => from_s > span.from_s && from_s < next_s);
    return [state(span.from_s, before), ...within.map(({ from_s, label }) => state(from_s, label))];
  });
}
