// Whether the page and the monitor speak to each other: the same words at every place of the page.
import type { Store } from "./store";

/** `no answer`: the monitor restarts, or the cell ended without a word; after some seconds that is `ended`. */
export type Link = "connecting" | "connected" | "no answer" | "ended" | "refused";

/** A monitor that restarts answers within this time (ms). */
const RESTART_MS = 5000;

export function linkOf({ connected, refused, ended, hello, heard_ms }: Store): Link {
  if (refused) return "refused";
  if (connected) return "connected";
  if (hello === null || heard_ms === null) return "connecting";
  return ended || Date.now() - heard_ms >= RESTART_MS ? "ended" : "no answer";
}
