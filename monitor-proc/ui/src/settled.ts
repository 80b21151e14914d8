// Tells the screenshot command when the page shows what its address asks for.
import { momentOfUrl } from "./net/moment";
import { FLAG } from "./net/snapshot";
import type { Store } from "./net/store";
import { getHash } from "./panels/hash";

/** Pictures drawn since everything was there: late materials and labels count. */
const CALM_FRAMES = 12;
/** How near the time that was asked for has to be (s). */
const NEAR_S = 0.1;

/**
 * Whether the page was opened for a picture: `#shot` says so, and the screenshot command
 * fixes the quality. Nothing then covers the cell.
 */
export function isPicture(): boolean {
  return getHash("shot") !== null || getHash("quality") !== null;
}

/**
 * Answers whether scene, state and the moment that the URL named when the page was
 * opened are on the screen.
 */
export function settled(store: Store): () => boolean {
  const time = momentOfUrl()?.time_s ?? null;
  const shows = () => {
    const { snapshot, scene, status } = store;
    if (snapshot === null || scene === null || status === null) return false;
    if (time === null) return true;
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
