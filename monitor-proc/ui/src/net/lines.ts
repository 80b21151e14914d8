// The order of the lines of the log.
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
