// Looks at moments of the past, as fast as they can be shown.
import type { Desk } from "../desk";

const SEEKS_A_SECOND = 12;

/** Simulated time (s), null for now; and the generation of physics where it is not the newest. */
export type Seek = (time: number | null, epoch?: number) => void;

/** Sends the newest wish, but not all of a fast hand. */
export function seeker(desk: Desk): Seek {
  let wish: { time_s: number | null; epoch?: number } | null = null;
  let waiting = false;
  const send = () => {
    waiting = false;
    if (wish === null) return;
    const command = { do: "seek" as const, ...wish };
    wish = null;
    waiting = true;
    void desk.send(command);
    setTimeout(send, 1000 / SEEKS_A_SECOND);
  };
  return (time_s, epoch) => {
    wish = epoch === undefined ? { time_s } : { time_s, epoch };
    if (!waiting) send();
  };
}
