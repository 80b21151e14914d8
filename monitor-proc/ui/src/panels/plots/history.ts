// The last thirty seconds of every signal, so that one dragged into a plot
// comes with its past.
import type { Store } from "../../net/store";
import { type Signal, signalsOf } from "./signals";

export const WINDOW_S = 30;
/** Thirty seconds of frames, and some. */
const SAMPLES = 2000;

export class History {
  signals: Signal[] = [];
  private times = new Float64Array(SAMPLES);
  private values = new Map<string, Float32Array>();
  private count = 0;
  private next = 0;
  private hops = "";
  private readonly listeners = new Set<() => void>();

  constructor(private readonly store: Store) {
    store.on("scene", () => this.rename());
    store.on("status", ({ latency }) => {
      const hops = latency.map(({ hop, arm }) => `${hop}/${arm}`).join();
      if (hops === this.hops) return;
      this.hops = hops;
      this.rename();
    });
    store.on("snapshot", () => this.sample());
    this.rename();
  }

  /** Calls `listener` when there are other signals. */
  on(listener: () => void): void {
    this.listeners.add(listener);
  }

  find(key: string): Signal | undefined {
    return this.signals.find((signal) => signal.key === key);
  }

  /** Times and, for each key, values of the window that ends at the last sample. */
  window(keys: string[]): (number | null)[][] {
    const times: number[] = [];
    const columns = keys.map((): (number | null)[] => []);
    const series = keys.map((key) => this.values.get(key));
    const last = this.count === 0 ? 0 : (this.times[(this.next + SAMPLES - 1) % SAMPLES] ?? 0);
    for (let back = this.count; back > 0; back--) {
      const at = (this.next + SAMPLES - back) % SAMPLES;
      const time = this.times[at] ?? 0;
      if (time < last - WINDOW_S) continue;
      times.push(time);
      for (const [index, values] of series.entries()) {
        const value = values?.[at] ?? NaN;
        columns[index]?.push(Number.isFinite(value) ? value : null);
      }
    }
    return [times, ...columns];
  }

  private rename(): void {
    this.signals = signalsOf(this.store.scene, this.store.status?.latency ?? []);
    const before = this.values;
    const fresh = () => new Float32Array(SAMPLES).fill(NaN);
    this.values = new Map(this.signals.map(({ key }) => [key, before.get(key) ?? fresh()]));
    for (const listener of this.listeners) listener();
  }

  private sample(): void {
    const { snapshot, status } = this.store;
    if (snapshot === null) return;
    const last = this.times[(this.next + SAMPLES - 1) % SAMPLES] ?? 0;
    if (this.count > 0 && snapshot.time === last) return;
    // A reset, or a look back: another story begins.
    if (this.count > 0 && (snapshot.time < last || snapshot.time > last + WINDOW_S)) this.count = 0;
    this.times[this.next] = snapshot.time;
    for (const { key, read } of this.signals) {
      const values = this.values.get(key);
      if (values !== undefined) values[this.next] = read(snapshot, status);
    }
    this.next = (this.next + 1) % SAMPLES;
    this.count = Math.min(this.count + 1, SAMPLES);
  }
}
