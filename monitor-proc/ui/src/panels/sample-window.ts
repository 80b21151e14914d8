// Samples of the last seconds, or of the span around the moment of the past that is looked at. Those that the page
// did not see come from the recorder.
import { type Span, snapshotsOf } from "../net/past";
import { FLAG, type Snapshot } from "../net/snapshot";
import type { Store } from "../net/store";

/** Snapshots read for one window. */
const READ_SAMPLES = 600;
/** A leap longer than this leaves a gap, which is read. */
const GAP_S = 2;
/** Another window is read when the moment shown is this near to its edge. */
const MARGIN_S = 5;
/** A shorter span is not read. */
const LEAST_S = 0.1;

export abstract class SampleWindow<Sample extends { time_s: number }> {
  protected live: Sample[] = [];
  protected past: { span: Span; samples: Sample[] } | null = null;
  private wantsEarlier = true;
  private reading = false;

  constructor(
    protected readonly store: Store,
    private readonly length_s: number,
  ) {}

  /** A sample of a snapshot that was recorded. */
  protected abstract recorded(snapshot: Snapshot): Sample;

  /** The moment of the past that is looked at, or null. */
  get cursor(): number | null {
    return this.looksBack ? (this.store.snapshot?.time ?? null) : null;
  }

  /** Reads the missing samples. */
  follow(): void {
    if (this.reading) return;
    if (this.looksBack) this.readAround();
    else if (this.wantsEarlier) this.readEarlier();
  }

  /** A recording has no other time than the one it shows. */
  protected get looksBack(): boolean {
    const { snapshot, hello } = this.store;
    return hello?.live !== false && ((snapshot?.flags ?? 0) & FLAG.notLive) !== 0;
  }

  protected get kept(): Sample[] {
    return this.looksBack ? (this.past?.samples ?? []) : this.live;
  }

  /** Starts again where `time_s` is not soon after the last live sample. */
  protected leap(time_s: number): void {
    const last_s = this.live.at(-1)?.time_s;
    if (last_s === undefined || (time_s >= last_s && time_s <= last_s + GAP_S)) return;
    this.live = [];
    this.wantsEarlier = true;
  }

  protected clear(): void {
    this.live = [];
    this.past = null;
    this.wantsEarlier = true;
  }

  /** The recorded samples before the first live one. */
  private readEarlier(): void {
    const first_s = this.live[0]?.time_s;
    const begin_s = this.store.timeline?.from_s;
    if (first_s === undefined || begin_s === undefined) return;
    this.wantsEarlier = false;
    const span = { from_s: Math.max(begin_s, first_s - this.length_s), to_s: first_s, epoch: null };
    if (span.to_s - span.from_s < LEAST_S) return;
    this.read(span, (samples) => {
      if (this.live[0]?.time_s === first_s) this.live.unshift(...samples.filter(({ time_s }) => time_s < first_s));
    });
  }

  /** A window with the moment looked at in its middle, where there is one. */
  private readAround(): void {
    const { snapshot, timeline, past } = this.store;
    if (snapshot === null || timeline === null) return;
    const epoch = past?.epoch ?? null;
    const { time } = snapshot;
    const span = this.past?.span;
    const edge = (limit: number, at: number) => Math.abs(limit - at) < LEAST_S || Math.abs(time - at) > MARGIN_S;
    const inside = span !== undefined && time >= span.from_s && time <= span.to_s;
    if (inside && span.epoch === epoch && edge(timeline.from_s, span.from_s) && edge(timeline.to_s, span.to_s)) return;
    const known = timeline.epochs.find((one) => one.epoch === epoch);
    const last = Math.max(known?.to_s ?? timeline.to_s, time);
    const from_s = Math.max(timeline.from_s, Math.min(time - this.length_s / 2, last - this.length_s));
    const wanted = { from_s, to_s: Math.min(last, from_s + this.length_s), epoch };
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
      use(snapshots.map((snapshot) => this.recorded(snapshot)));
    });
  }
}
