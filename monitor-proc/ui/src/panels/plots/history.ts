// What the plots show: the last thirty seconds, or the span around the moment of
// the past that is looked at. What the page did not see comes from the recorder.
import { snapshotsOf, type Span } from "../../net/past";
import type { Status } from "../../net/protocol";
import { FLAG, type Snapshot } from "../../net/snapshot";
import type { Store } from "../../net/store";
import { type Signal, signalsOf } from "./signals";

export const WINDOW_S = 30;
/** Thirty seconds of frames, and some. */
const MOST_SAMPLES = 2000;
/** Snapshots read for one window. */
const READ_SAMPLES = 600;
/** A leap longer than this leaves a gap, which is read. */
const GAP_S = 2;
/** Another window is read when the moment shown is this near to its edge. */
const MARGIN_S = 5;

/** A snapshot with what was said beside it; null where that is not recorded. */
interface Sample {
  snapshot: Snapshot;
  status: Status | null;
}

export class History {
  signals: Signal[] = [];
  private live: Sample[] = [];
  private past: { span: Span; samples: Sample[] } | null = null;
  private wantsEarlier = true;
  private reading = false;
  private hops = "";
  private readonly listeners = new Set<() => void>();

  constructor(private readonly store: Store) {
    store.on("scene", () => {
      this.live = [];
      this.past = null;
      this.wantsEarlier = true;
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

  /** The moment looked at, where that is in the past. */
  get cursor(): number | null {
    return this.looksBack ? (this.store.snapshot?.time ?? null) : null;
  }

  /** Times and, for each key, values of the window. */
  window(keys: string[]): (number | null)[][] {
    const samples = this.looksBack ? (this.past?.samples ?? []) : this.live;
    const last = samples.at(-1)?.snapshot.time ?? 0;
    const shown = this.looksBack ? samples : samples.filter(({ snapshot }) => snapshot.time >= last - WINDOW_S);
    const columns = keys.map((key) => {
      const read = this.find(key)?.read ?? (() => NaN);
      return shown.map(({ snapshot, status }) => finite(read(snapshot, status)));
    });
    return [shown.map(({ snapshot }) => snapshot.time), ...columns];
  }

  /** Reads what the window lacks. */
  follow(): void {
    if (this.reading) return;
    if (this.looksBack) this.readAround();
    else if (this.wantsEarlier) this.readEarlier();
  }

  /** A recording has no other time than the one it shows. */
  private get looksBack(): boolean {
    const { snapshot, hello } = this.store;
    return hello?.live !== false && ((snapshot?.flags ?? 0) & FLAG.notLive) !== 0;
  }

  private rename(): void {
    this.signals = signalsOf(this.store.scene, this.store.status?.latency ?? []);
    for (const listener of this.listeners) listener();
  }

  private sample(snapshot: Snapshot): void {
    if (this.looksBack) return;
    const last = this.live.at(-1)?.snapshot.time;
    if (snapshot.time === last) return;
    if (last !== undefined && (snapshot.time < last || snapshot.time > last + GAP_S)) {
      this.live = [];
      this.wantsEarlier = true;
    }
    this.live.push({ snapshot, status: this.store.status });
    // Not at every frame: the rest is moved.
    if (this.live.length > 1.1 * MOST_SAMPLES) this.live.splice(0, this.live.length - MOST_SAMPLES);
  }

  /** What came before the first live sample. */
  private readEarlier(): void {
    const first = this.live[0]?.snapshot.time;
    const begin = this.store.timeline?.from_s;
    if (first === undefined || begin === undefined) return;
    this.wantsEarlier = false;
    const span = { from_s: Math.max(begin, first - WINDOW_S), to_s: first, epoch: null };
    if (span.to_s - span.from_s < 0.1) return;
    this.read(span, (samples) => {
      if (this.live[0]?.snapshot.time !== first) return;
      this.live.unshift(...samples.filter(({ snapshot }) => snapshot.time < first));
    });
  }

  /** A window with the moment looked at in its middle, where there is one. */
  private readAround(): void {
    const { snapshot, timeline, past } = this.store;
    if (snapshot === null || timeline === null) return;
    const epoch = past?.epoch ?? null;
    const { time } = snapshot;
    const span = this.past?.span;
    const edge = (limit: number, at: number) => Math.abs(limit - at) < 0.1 || Math.abs(time - at) > MARGIN_S;
    const inside = span !== undefined && time >= span.from_s && time <= span.to_s;
    if (inside && span.epoch === epoch && edge(timeline.from_s, span.from_s) && edge(timeline.to_s, span.to_s)) return;
    const known = timeline.epochs.find((one) => one.epoch === epoch);
    const last = Math.max(known?.to_s ?? timeline.to_s, time);
    const from_s = Math.max(timeline.from_s, Math.min(time - WINDOW_S / 2, last - WINDOW_S));
    const wanted = { from_s, to_s: Math.min(last, from_s + WINDOW_S), epoch };
    // What cannot be read is not asked for again and again.
    if (span !== undefined && JSON.stringify(span) === JSON.stringify(wanted)) return;
    this.read(wanted, (samples) => {
      this.past = { span: wanted, samples };
    });
  }

  private read(span: Span, use: (samples: Sample[]) => void): void {
    this.reading = true;
    void snapshotsOf(span, READ_SAMPLES).then((snapshots) => {
      this.reading = false;
      use(snapshots.map((snapshot) => ({ snapshot, status: null })));
    });
  }
}

function finite(value: number): number | null {
  return Number.isFinite(value) ? value : null;
}
