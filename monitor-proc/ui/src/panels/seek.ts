// A moment of the past that is looked at.
import type { PanelContext } from "./context";

/** Shows the moment of a line of the log, in the history that the line is of. */
export function lookAt(context: PanelContext, line: { time_s: number; epoch: number | null }): void {
  const { time_s, epoch } = line;
  const isOther = epoch !== null && !context.store.isCurrent(line);
  const seek = { do: "seek", time_s, ...(isOther ? { epoch } : {}) } as const;
  // A replay that plays would leave the moment at once.
  const isReplay = context.store.hello?.live === false;
  void (isReplay ? context.send({ do: "pause" }, seek) : context.send(seek));
}
