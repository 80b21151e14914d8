// What the plots show: the last thirty seconds, or the span around the moment of
// the past that is looked at.
import type { Status } from "../../net/protocol";
import type { Snapshot } from "../../net/snapshot";
import type { Store } from "../../net/store";
import { SampleWindow } from "../sample-window";
import { type Signal, signalsOf } from "./signals";

const WINDOW_S = 30;
/** Thirty seconds of frames, and some. */
const MOST_SAMPLES = 2000;

/** A snapshot with what was said beside it; null where that is not recorded. */
interface Sample {
  time_s: number;
  snapshot: Snapshot;
  status: Status | null;
}

export class History extends SampleWindow<Sample> {
  signals: Signal[] = [];
  private hops = "";
  private readonly listeners = new Set<() => void>();

  constructor(store: Store) {
    super(store, WINDOW_S);
    store.on("scene", () => {
      this.clear();
      this.rename();
    });
    store.on("status", ({ latency }) => {
      const hops = latency.map(({ hop, arm }) => `${hop}/${arm}`).join();
      if (hops === this.hops) return;
      this.hops = hops;
      this.rename();
    });
    store.on("snapshot", (snapshot) => this.sample(snapshot));
    this.rename();
  }

  /** Calls `listener` when there are other signals. */
  on(listener: () => void): void {
    this.listeners.add(listener);
  }

  find(key: string): Signal | undefined {
    return this.signals.find((signal) => signal.key === key);
  }

  /** Times and, for each key, values of the window. */
  window(keys: string[]): (number | null)[][] {
    const last = this.kept.at(-1)?.time_s ?? 0;
    const shown = this.looksBack ? this.kept : this.kept.filter(({ time_s }) => time_s >= last - WINDOW_S);
    const columns = keys.map((key) => {
      const read = this.find(key)?.read ?? (() => NaN);
      return shown.map(({ snapshot, status }) => finite(read(snapshot, status)));
    });
    return [shown.map(({ time_s }) => time_s), ...columns];
  }

  protected recorded(snapshot: Snapshot): Sample {
    return { time_s: snapshot.time, snapshot, status: null };
  }

  private rename(): void {
    this.signals = signalsOf(this.store.scene, this.store.status?.latency ?? []);
    for (const listener of this.listeners) listener();
  }

  private sample(snapshot: Snapshot): void {
    if (this.looksBack || snapshot.time === this.live.at(-1)?.time_s) return;
    this.leap(snapshot.time);
    this.live.push({ time_s: snapshot.time, snapshot, status: this.store.status });
    // Not at every frame: the rest is moved.
    if (this.live.length > 1.1 * MOST_SAMPLES) this.live.splice(0, this.live.length - MOST_SAMPLES);
  }
}

function finite(value: number): number | null {
  return Number.isFinite(value) ? value : null;
}
