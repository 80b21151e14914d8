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
