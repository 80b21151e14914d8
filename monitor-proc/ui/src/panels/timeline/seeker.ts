// Looks at moments of the past, as fast as they can be shown.
import type { PanelContext } from "../context";

const SEEKS_A_SECOND = 12;

/** Simulated time (s), null for now; and the generation of physics where it is not the newest. */
export type Seek = (time: number | null, epoch?: number) => void;

/** Sends the newest target, but not all of a fast hand. */
export function seeker(context: PanelContext): Seek {
  let target: { time_s: number | null; epoch?: number } | null = null;
  let waiting = false;
  const send = () => {
    waiting = false;
    if (target === null) return;
    const command = { do: "seek" as const, ...target };
    target = null;
    waiting = true;
    void context.send(command);
    setTimeout(send, 1000 / SEEKS_A_SECOND);
  };
  return (time_s, epoch) => {
    target = epoch === undefined ? { time_s } : { time_s, epoch };
    if (!waiting) send();
  };
}
