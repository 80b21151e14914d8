// The moment of the past that a person looks at outlives its run: `--loop` starts the next seed by itself, and the
// monitor with the recorder of the earlier one ends. The page then shows its own snapshots until the person returns to now.
import { answerFrom, snapshotsOf } from "./past";
import type { Ack, Command, TextMessage } from "./protocol";
import type { Snapshot } from "./snapshot";
import type { Store } from "./store";

/** Largest number of snapshots, and longest span, that the monitor reads at once. */
const READ_SAMPLES = 1000;
const READ_S = 600;
/** Another scene that was asked for is there, or was refused, after this time (ms). */
const LOADED_MS = 2000;
/** So much is read of what follows the end of a task, in steps of the least length (s). */
const AFTER_S = 6;
const LEAST_S = 0.5;
/** The monitor refuses a second reader: it is asked again after this time (ms). */
const AGAIN_MS = 500;

export class Earlier {
  /** Snapshots of the run that is looked at, oldest first. */
  private snapshots: Snapshot[] = [];
  /** The run that `snapshots` are of, or were asked for, and when its task had ended (s). */
  private run: string | null = null;
  private over_s = 0;
  private reads = false;

  /** `reconnect` has the monitor tell everything about now. */
  constructor(
    private readonly store: Store,
    private readonly reconnect: () => void,
  ) {
    store.on("status", () => this.prepare());
    store.on("moment", () => this.prepare());
  }

  /** Whether `data` is of a later run than the one that is looked at, and not for the page. */
  hides(data: ArrayBuffer | TextMessage): boolean {
    const { store } = this;
    if (store.earlier !== null) return data instanceof ArrayBuffer || data.t !== "ack";
    if (data instanceof ArrayBuffer || data.t !== "hello" || store.past === null) return false;
    const { hello } = store;
    if (hello === null || !hello.live || hello.run.id === data.run.id) return false;
    store.earlier = { seed: hello.run.seed, hasTask: true };
    answerFrom(this.snapshots);
    store.emit("connection", true);
    return true;
  }

  /** The answer to a command that is about the earlier run; null where it is about another one. */
  answer(command: Command): Ack | null {
    const { store } = this;
    if (store.earlier === null) return null;
    const ack = (ok: boolean, message = ""): Ack => ({ id: 0, ok, tick: null, message });
    if (command.do === "load") this.leave(LOADED_MS);
    if (command.do !== "seek") return null;
    if (command.time_s === null) {
      this.leave(0);
      return ack(true);
    }
    const wanted = command.time_s;
    const away = ({ time }: Snapshot) => Math.abs(time - wanted);
    const nearer = (one: Snapshot | null, other: Snapshot) => (one === null || away(other) < away(one) ? other : one);
    const nearest = this.snapshots.reduce(nearer, null);
    if (nearest === null) return ack(false, "the run has ended, and the page has no other moment of it");
    store.showEarlier(nearest);
    return ack(true);
  }

  /** Reads the run when its task has ended, and again as it grows: the next run starts some seconds later. */
  private prepare(): void {
    const { store, reads } = this;
    const { past, hello, newest, timeline } = store;
    if (reads || store.earlier !== null || past === null || hello?.live !== true || timeline === null) return;
    const isOver = newest?.task.outcome === "done" || newest?.task.outcome === "failed";
    if (!isOver) return;
    const { from_s, to_s } = timeline;
    if (this.run !== hello.run.id) {
      this.run = hello.run.id;
      this.snapshots = [];
      this.over_s = to_s;
    }
    const last = this.snapshots.at(-1)?.time;
    const from = Math.max(last ?? from_s, from_s, to_s - READ_S);
    if (to_s < from + LEAST_S || (last ?? 0) > this.over_s + AFTER_S) return;
    this.reads = true;
    void snapshotsOf({ from_s: from, to_s, epoch: null }, READ_SAMPLES).then((snapshots) => {
      this.snapshots.push(...snapshots.filter(({ time }) => time > (last ?? -Infinity)));
      setTimeout(() => (this.reads = false), AGAIN_MS);
    });
  }

  private leave(after_ms: number): void {
    this.store.leaveEarlier();
    answerFrom(null);
    this.snapshots = [];
    this.run = null;
    setTimeout(this.reconnect, after_ms);
  }
}
