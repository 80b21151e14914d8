// Tells the screenshot command when the page shows what its address asks for.
import { FLAG } from "./net/snapshot";
import type { Store } from "./net/store";
import { getHash } from "./panels/hash";

/** Pictures drawn since everything was there: late materials and labels count. */
const CALM_FRAMES = 12;
/** How near the time that was asked for has to be (s). */
const NEAR_S = 0.1;

/**
 * Follows `time=SECONDS` in the URL's hash, and answers whether scene, state and
 * that time are on the screen.
 */
export function settled(store: Store): () => boolean {
  const text = getHash("time");
  const time = text === null ? null : Number(text);
  if (time !== null && Number.isFinite(time)) {
    store.on("scene", () => void store.command({ do: "seek", time_s: time }));
  }
  const shows = () => {
    const { snapshot, scene, status } = store;
    if (snapshot === null || scene === null || status === null) return false;
    if (time === null || !Number.isFinite(time)) return true;
    return (snapshot.flags & FLAG.notLive) !== 0 && Math.abs(snapshot.time - time) < NEAR_S;
  };
  let calm = 0;
  const count = () => {
    calm = shows() ? calm + 1 : 0;
    if (calm < CALM_FRAMES) requestAnimationFrame(count);
  };
  requestAnimationFrame(count);
  return () => calm >= CALM_FRAMES;
}
