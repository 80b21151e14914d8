// The load of a suction cup over the last minute, or around the moment of the past
// that is looked at.
import { snapshotsOf, type Span } from "../../../net/past";
import type { LogLine } from "../../../net/protocol";
import { FLAG, type Snapshot } from "../../../net/snapshot";
import type { Store } from "../../../net/store";

export const WINDOW_S = 60;
/** Live samples are at least so far apart (s). */
const STEP_S = 0.05;
const READ_SAMPLES = 600;
/** A leap longer than this leaves a gap, which is read. */
const GAP_S = 2;
/** Another span is read when the moment shown is this near to its edge. */
const MARGIN_S = 5;

export interface Sample {
  time_s: number;
  /** Share of the break limit; null while nothing hangs at the cup. */
  load: number | null;
  /** Null where it is not recorded (N). */
  force_n: number | null;
}

export class LoadHistory {
  private live: Sample[] = [];
  private past: { span: Span; samples: Sample[] } | null = null;
  private wantsEarlier = true;
  private reading = false;
  private readonly off: () => void;

  constructor(
    private readonly store: Store,
    private readonly arm: number,
  ) {
    this.off = store.on("snapshot", (snapshot) => this.add(snapshot));
  }

  stop(): void {
    this.off();
  }

  /** The moment of the past that is looked at, or null. */
  get cursor(): number | null {
    return this.looksBack ? (this.store.snapshot?.time ?? null) : null;
  }

  /** A grip breaks at its limit, in one tick that no snapshot may show. */
  get samples(): Sample[] {
    const samples = this.looksBack ? (this.past?.samples ?? []) : this.live;
    const breaks = this.breaks.map(({ time_s }) => ({ time_s, load: 1, force_n: null }));
    return breaks.length === 0 ? samples : [...samples, ...breaks].sort((a, b) => a.time_s - b.time_s);
  }

  /** From when to when is shown (s). */
  get span(): [number, number] {
    if (this.looksBack && this.past !== null) return [this.past.span.from_s, this.past.span.to_s];
    const to = this.store.snapshot?.time ?? 0;
    return [Math.max(0, to - WINDOW_S), Math.max(to, 1)];
  }

  /** Log lines of broken grips within the span that is shown. */
  get breaks(): LogLine[] {
    const [from, to] = this.span;
    const inside = ({ time_s }: LogLine) => time_s >= from && time_s <= to;
    return this.store.log.filter((line) => line.mark === "break" && inside(line) && this.store.isCurrent(line));
  }

  /** Reads the missing samples. */
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

  private add(snapshot: Snapshot): void {
    if (this.looksBack) return;
    const last = this.live.at(-1)?.time_s ?? -Infinity;
    const { time } = snapshot;
    if (time >= last && time < last + STEP_S) return this.raise(snapshot);
    if (time < last || (time > last + GAP_S && last >= 0)) {
      this.live = [];
      this.wantsEarlier = true;
    }
    const force = this.store.status?.equipment?.suction[this.arm]?.force_n ?? null;
    this.live.push(this.sample(snapshot, force));
    while ((this.live[0]?.time_s ?? time) < time - WINDOW_S) this.live.shift();
  }

  /** A sample has the largest load of its interval. */
  private raise({ arms }: Snapshot): void {
    const sample = this.live.at(-1);
    const arm = arms[this.arm];
    if (sample === undefined || arm?.attached !== true) return;
    sample.load = Math.max(sample.load ?? 0, arm.load);
  }

  private sample({ time, arms }: Snapshot, force_n: number | null): Sample {
    const arm = arms[this.arm];
    return { time_s: time, load: arm?.attached === true ? arm.load : null, force_n };
  }

  private readEarlier(): void {
    const first = this.live[0]?.time_s;
    const begin = this.store.timeline?.from_s;
    if (first === undefined || begin === undefined) return;
    this.wantsEarlier = false;
    const span = { from_s: Math.max(begin, first - WINDOW_S), to_s: first, epoch: null };
    if (span.to_s - span.from_s < STEP_S) return;
    this.read(span, (samples) => {
      if (this.live[0]?.time_s === first) this.live.unshift(...samples.filter(({ time_s }) => time_s < first));
    });
  }

  private readAround(): void {
    const { snapshot, timeline, past } = this.store;
    if (snapshot === null || timeline === null) return;
    const epoch = past?.epoch ?? null;
    const { time } = snapshot;
    const known = timeline.epochs.find((one) => one.epoch === epoch);
    const last = Math.max(known?.to_s ?? timeline.to_s, time);
    const from_s = Math.max(timeline.from_s, Math.min(time - WINDOW_S / 2, last - WINDOW_S));
    const wanted = { from_s, to_s: Math.min(last, from_s + WINDOW_S), epoch };
    const span = this.past?.span;
    const isInside = (margin: number) => span !== undefined && time >= span.from_s + margin && time <= span.to_s - margin;
    const isSame = span !== undefined && span.from_s === wanted.from_s && span.to_s === wanted.to_s;
    const atEdge = span !== undefined && isInside(0) && (span.from_s <= timeline.from_s || span.to_s >= last);
    if (span?.epoch === epoch && (isSame || atEdge || isInside(MARGIN_S))) return;
    this.read(wanted, (samples) => {
      this.past = { span: wanted, samples };
    });
  }

  private read(span: Span, use: (samples: Sample[]) => void): void {
    this.reading = true;
    void snapshotsOf(span, READ_SAMPLES).then((snapshots) => {
      this.reading = false;
      use(snapshots.map((snapshot) => this.sample(snapshot, null)));
    });
  }
}
