// The spans of the lanes as the page shows them: the spans of the task, with phases that end with their task, with work
// after the task was done, and with faults that the task does not know of.
import type { Span } from "./protocol";
import { withResets } from "./resets";
import { NOT_REACHED, PICKING_UP, type WrongFrom } from "./wrong";

/** Phases in which an arm waits, and works no more. */
export const RESTS = /(^|_)(done|failed|rest|home|idle|standby|ready)$/i;
/** A phase that starts so soon after the end of a task is part of the same decision (s). */
export const SAME_S = 0.05;

/** Whether a span is of the history that led to now. */
type IsCurrent = (line: { epoch: number | null; time_s: number }) => boolean;

/** What the spans are made from. */
export interface Told {
  lanes: Span[];
  wrong: WrongFrom[];
  losses: number[];
  resets: number[];
  timeline: { from_s: number; to_s: number } | null;
}

export class ShownSpans {
  private from: unknown[] = [];
  private all: Span[] = [];
  /** An added span keeps its identity, so that its bar is drawn once. */
  private made = new Map<string, Span>();

  /**
   * The spans of the current history, oldest first; the same list until something changed. `losses` and `resets`: when a
   * grip was lost, and when the task was reset (s).
   */
  of({ lanes, wrong, losses, resets, timeline }: Told, isCurrent: IsCurrent): Span[] {
    const from = [lanes, wrong, losses.join(), resets.join(), timeline];
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
    const length_s = timeline === null ? 0 : timeline.to_s - timeline.from_s;
    const cut = (lane: Span[], arms: Span[][] = []) => withResets(lane, resets, length_s, add, arms);
    const all = names.map((name) => now.filter(({ lane, kind }) => lane === name && kind === "phase"));
    const phases = all.filter(({ length }) => length > 0);
    const outcome = withAgain(cut(now.filter(({ kind }) => kind === "task")), pickups(now, losses), add);
    const shown = names.flatMap((name) => {
      const lane = now.filter((span) => span.lane === name);
      const kind = lane[0]?.kind;
      if (kind === "phase") return withEnds(cut(lane, phases), outcome, add);
      return kind === "task" ? withStates(outcome, wrong, add) : lane;
    });
    shown.sort((one, other) => one.from_s - other.from_s);
    const isSame = shown.length === this.all.length && shown.every((span, index) => span === this.all[index]);
    if (!isSame) this.all = shown;
    return this.all;
  }
}

type Add = (like: Span, change: Partial<Span>) => Span;

/** From when to when (s). */
interface Pickup {
  from_s: number;
  to_s: number;
}

/** From each loss of a grip until an arm holds something again. */
function pickups(now: Span[], losses: number[]): Pickup[] {
  const held = now.filter(({ kind, label }) => kind === "grip" && label !== "").map(({ from_s }) => from_s);
  return losses.map((from_s) => ({ from_s, to_s: Math.min(...held.filter((at_s) => at_s > from_s)) }));
}

/**
 * A task that lost its grip picks up again until it holds the object. One that was done works again from then on: its end
 * is told once, not after each grip.
 */
function withAgain(lane: Span[], all: Pickup[], add: Add): Span[] {
  return lane.flatMap((span, index) => {
    if (span.label !== "done" && span.label !== "running") return [span];
    const next_s = lane[index + 1]?.from_s ?? Infinity;
    let last_s = span.from_s;
    const parts = [span];
    for (const { from_s, to_s } of all) {
      if (from_s <= last_s || from_s >= next_s) continue;
      parts.push(add(span, { from_s, label: PICKING_UP, tone: "warn" }));
      const isDone = span.label === "done";
      if (to_s < next_s) parts.push(add(span, { from_s: to_s, ...(isDone ? { label: "running", tone: "info" } : {}) }));
      last_s = Math.min(to_s, next_s);
    }
    return parts;
  });
}

/** While the task has ended, its phase is that it ended. */
function withEnds(lane: Span[], outcome: Span[], add: Add): Span[] {
  const ends = outcome.flatMap(({ label, from_s, epoch }, index) =>
    label === "done" || label === "failed"
      ? [{ label, from_s, epoch, to_s: outcome[index + 1]?.from_s ?? Infinity }]
      : [],
  );
  const all: Span[] = [];
  for (const [index, span] of lane.entries()) {
    const next_s = lane[index + 1]?.from_s ?? Infinity;
    let at_s = span.from_s;
    const work = (to_s: number) => {
      // The short remainder of a phase beside an end is not a phase.
      if (at_s === span.from_s ? to_s > at_s : to_s - at_s > SAME_S)
        all.push(at_s === span.from_s ? span : add(span, { from_s: at_s }));
    };
    for (const { label, from_s, epoch, to_s } of span.label === "" ? [] : ends) {
      if (to_s <= at_s || from_s >= next_s) continue;
      work(from_s);
      const name = /[a-z]/.test(span.label) ? label : label.toUpperCase();
      if (all.at(-1)?.label !== name) all.push(add(span, { from_s: Math.max(from_s, at_s), epoch, label: name }));
      at_s = Math.min(to_s, next_s);
    }
    if (at_s < next_s) work(next_s);
  }
  return all;
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
