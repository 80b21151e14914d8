// The load of a suction cup over the last minute, or around the moment of the past
// that is looked at.
import type { LogLine } from "../../../net/protocol";
import type { Snapshot } from "../../../net/snapshot";
import type { Store } from "../../../net/store";
import { SampleWindow } from "../../sample-window";

const WINDOW_S = 60;
/** Live samples are at least so far apart (s). */
const STEP_S = 0.05;

interface Sample {
  time_s: number;
  /** Share of the break limit; null while nothing hangs at the cup. */
  load: number | null;
  /** Null where it is not recorded (N). */
  force_n: number | null;
}

export class LoadHistory extends SampleWindow<Sample> {
  readonly stop: () => void;

  constructor(
    store: Store,
    private readonly arm: number,
  ) {
    super(store, WINDOW_S);
    this.stop = store.on("snapshot", (snapshot) => this.add(snapshot));
  }

  /** A grip breaks at its limit, in one tick that no snapshot may show. */
  get samples(): Sample[] {
    const breaks = this.breaks.map(({ time_s }) => ({ time_s, load: 1, force_n: null }));
    return breaks.length === 0 ? this.kept : [...this.kept, ...breaks].sort((a, b) => a.time_s - b.time_s);
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

  protected recorded(snapshot: Snapshot): Sample {
    return this.sample(snapshot, null);
  }

  private add(snapshot: Snapshot): void {
    if (this.looksBack) return;
    const last = this.live.at(-1)?.time_s ?? -Infinity;
    const { time } = snapshot;
    if (time >= last && time < last + STEP_S) return this.raise(snapshot);
    this.leap(time);
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
}
