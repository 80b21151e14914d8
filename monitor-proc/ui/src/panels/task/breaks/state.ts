// Breakpoints of the cell: all its pages see the same ones.
import type { Store } from "../../../net/store";
import type { PanelContext } from "../../context";

/** Breakpoints by name; null where there is no cell that could have some. */
export function breaksOf({ status, hello }: Store): Map<string, number> | null {
  if (status === null || hello?.live === false) return null;
  return new Map(status.breaks.map(({ name, hits }) => [name, hits]));
}

/** Name of the breakpoint that paused the cell, or null. */
export function reached({ status }: Store): string | null {
  return status?.pause_cause === "breakpoint" ? status.pause_detail : null;
}

/** Why no breakpoint can be set or removed now, or null. */
export function breakRefusal(context: PanelContext): string | null {
  if (breaksOf(context.store) === null) return "no cell to pause";
  return context.cellRefusal();
}

/** The same on the command line. */
export function breakTwin(context: PanelContext, name: string): string {
  const on = breaksOf(context.store)?.has(name) !== true;
  // A name of a shell's own characters would be something else there.
  const word = /^[\w.-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`;
  return `robocell break ${on ? "" : "--remove "}${word}`;
}

/** Sets the breakpoint `name`, or removes it. */
export function toggleBreak(context: PanelContext, name: string): void {
  const reason = breakRefusal(context);
  if (reason !== null) {
    context.notify(`not now: ${reason}`);
    return;
  }
  const on = breaksOf(context.store)?.has(name) !== true;
  void context.send({ do: "break", name, on });
}
