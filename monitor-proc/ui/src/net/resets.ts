// A reset of the task starts its states again. States during a reset last less than two decisions of the task, and a
// sample may miss them: cut at the resets, the lanes of a cell, of its history and of a recording are the same.
import type { Span } from "./protocol";

/** A recording tells its states at so many moments at most, whose distance is not less (s). */
const MOMENTS = 12_000;
const LEAST_S = 0.01;
/** A state that follows a reset may begin so much before its line (s). */
const BEFORE_S = 0.02;

type Add = (like: Span, change: Partial<Span>) => Span;

/**
 * `lane`, of the task or of a phase, cut at each of `resets` (s); `length_s`: of all that is recorded; `arms`: the lanes
 * of the phases of all arms, where the lane is one of several.
 */
export function withResets(lane: Span[], resets: number[], length_s: number, add: Add, arms: Span[][] = []): Span[] {
  const after_s = Math.max(LEAST_S, length_s / MOMENTS) + BEFORE_S;
  const isKept = (at_s: number) => arms.length < 2 || isNamed(lane, arms, at_s, after_s);
  return resets.reduce((cut, at_s) => cutAt(cut, { at_s, after_s, isKept: isKept(at_s) }, add), lane);
}

interface Cut {
  at_s: number;
  after_s: number;
  /** Whether the state before the reset restarts where no other one follows. */
  isKept: boolean;
}

function isNear(span: Span | undefined, at_s: number, after_s: number): boolean {
  return span !== undefined && span.from_s >= at_s - BEFORE_S && span.from_s <= at_s + after_s;
}

/** Whether the task names the arm of `lane` after a reset: it names one, that of the latest phase if no arm starts one. */
function isNamed(lane: Span[], arms: Span[][], at_s: number, after_s: number): boolean {
  if (arms.some((one) => one.some((span) => span.label !== "" && isNear(span, at_s, after_s)))) return false;
  const begun = (one: Span[]) =>
    Math.max(...one.filter(({ from_s, label }) => from_s < at_s && label !== "").map(({ from_s }) => from_s));
  return arms.every((one) => begun(one) <= begun(lane));
}

function cutAt(lane: Span[], { at_s, after_s, isKept }: Cut, add: Add): Span[] {
  const first = lane.findIndex((span) => isNear(span, at_s, after_s));
  if (first < 0) {
    const after = lane.filter(({ from_s }) => from_s < at_s).length;
    const span = lane[after - 1];
    if (span === undefined || span.label === "") return lane;
    const begun = add(span, isKept ? { from_s: at_s } : { from_s: at_s, label: "" });
    return [...lane.slice(0, after), begun, ...lane.slice(after)];
  }
  let begin = first;
  while (isBetween(lane[begin]) && isNear(lane[begin + 1], at_s, after_s)) begin++;
  const span = lane[begin];
  if (span === undefined) return lane;
  return [...lane.slice(0, first), span.from_s === at_s ? span : add(span, { from_s: at_s }), ...lane.slice(begin + 1)];
}

/** Whether it may be what a task is for a moment while it is reset. */
function isBetween(span: Span | undefined): boolean {
  return span?.label === "" || (span?.kind === "task" && span.label === "idle");
}
