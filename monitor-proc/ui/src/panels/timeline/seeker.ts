// Looks at moments of the past, as fast as they can be shown.
import type { Desk } from "../desk";

const SEEKS_A_SECOND = 12;

/** Sends the newest wish, but not all of a fast hand. */
export function seeker(desk: Desk): (time: number) => void {
  let wish: number | null = null;
  let waiting = false;
  const send = () => {
    waiting = false;
    if (wish === null) return;
    const time = wish;
    wish = null;
    waiting = true;
    void desk.send({ do: "seek", time_s: time });
    setTimeout(send, 1000 / SEEKS_A_SECOND);
  };
  return (time) => {
    wish = time;
    if (!waiting) send();
  };
}
