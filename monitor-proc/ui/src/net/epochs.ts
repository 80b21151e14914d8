// A restart of physics sets simulated time back: a time belongs to an epoch.

/** What the recorder holds of one epoch, a generation of physics. */
export interface EpochSpan {
  epoch: number;
  from_s: number;
  to_s: number;
}

/**
 * Whether `time_s` of `epoch` is part of the history that led to now: of earlier
 * epochs that is what came before physics resumed. `epochs` are oldest first.
 */
export function isCurrent(epochs: EpochSpan[], epoch: number | null, time_s: number): boolean {
  const at = epochs.findIndex((one) => one.epoch === epoch);
  return at < 0 || epochs.slice(at + 1).every((later) => time_s < later.from_s);
}

/**
 * Where on the timeline a failure at `time_s` of `epoch` is marked: at that time, or
 * where physics resumed if the history after that was discarded. A crash of physics
 * itself is always in such a part.
 */
export function markedAt(epochs: EpochSpan[], epoch: number | null, time_s: number): number {
  const at = epochs.findIndex((one) => one.epoch === epoch);
  const later = at < 0 ? [] : epochs.slice(at + 1);
  return Math.min(time_s, ...later.map((one) => one.from_s));
}
