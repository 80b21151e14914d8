// The order of the lines of the log, and what some of them are about.
import type { LogLine } from "./protocol";

/** A line comes so late at most (simulated s): an operator's command is told after what the task did meanwhile. */
const LATE_S = 10;

/** Adds `line` to `log` in the order of time; whether it is the last one. */
export function addInOrder(log: LogLine[], line: LogLine): boolean {
  let at = log.length;
  const isLater = (one: LogLine | undefined) =>
    one !== undefined && one.epoch === line.epoch && one.time_s > line.time_s && one.time_s - line.time_s < LATE_S;
  while (isLater(log[at - 1])) at--;
  log.splice(at, 0, line);
  return at === log.length - 1;
}

/** Whether the task was reset then. */
export function isReset({ text }: LogLine): boolean {
  return text === "[task] reset";
}

/** `known` and those of `lines` that tell of a reset and are new. */
export function withNewResets(known: LogLine[], lines: LogLine[]): LogLine[] {
  const found = lines.filter(
    (line) => isReset(line) && known.every((one) => one.time_s !== line.time_s || !isReset(one)),
  );
  return found.length === 0 ? known : [...known, ...found];
}
