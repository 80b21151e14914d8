// Events that no process tells of, as the states show them: an object that fell out of the cell, a person who pulls an
// object or pauses the clock, a target that is not reached.
import { lostOf } from "./lost";
import { snapshotsOf } from "./past";
import type { LogLine, Scene } from "./protocol";
import { FLAG, isUnreachable, OBJECT, type Snapshot } from "./snapshot";
import type { Store } from "./store";

/** An object that was let go for less is still pulled (simulated s). */
const PULLED_S = 1;
/** An arm has to be at rest for so long (simulated s). */
const REST_S = 0.5;
/** States of what was recorded before, and their least length (s). */
const READ_SAMPLES = 400;
const LEAST_READ_S = 1;
/** The monitor tells of a command of this page within this time (ms); one of others is told of here. */
const TOLD_MS = 700;
/** A replay that leaps farther was not played (s). */
const LEAP_S = 1;

type Found = Pick<LogLine, "time_s" | "text" | "mark">;

/** Follows states one after the other. */
class States {
  private lost = new Set<string>();
  /** By object: when it was pulled last (s). */
  private readonly pulled = new Map<string, number>();
  /** By arm: since when it rests away from its target (s), and whether that was told. */
  private readonly away = new Map<number, { since_s: number; told: boolean }>();
  private time_s = -Infinity;

  constructor(private readonly scene: Scene) {}

  /** What happened since the state before. */
  next(snapshot: Snapshot): Found[] {
    const isFirst = this.time_s === -Infinity;
    const time_s = snapshot.time;
    // Physics was restarted, or the scene reset.
    if (time_s < this.time_s) this.away.clear();
    this.time_s = time_s;
    const lost = lostOf(this.scene, snapshot);
    const found: Found[] = [];
    for (const name of isFirst ? [] : lost) {
      if (!this.lost.has(name)) found.push({ time_s, text: `object lost: ${name} fell out of the cell`, mark: "drop" });
    }
    this.lost = new Set(lost);
    return [...found, ...this.pulls(snapshot), ...this.misses(snapshot)];
  }

  private pulls({ objects, time: time_s }: Snapshot): Found[] {
    const found: Found[] = [];
    for (const [index, { flags }] of objects.entries()) {
      const name = this.scene.objects[index]?.name;
      if ((flags & OBJECT.dragged) === 0 || name === undefined) continue;
      const before = this.pulled.get(name);
      this.pulled.set(name, time_s);
      if (before === undefined || Math.abs(time_s - before) > PULLED_S) found.push({ time_s, text: `by hand: ${name} is pulled`, mark: "hand" });
    }
    return found;
  }

  /** Of a task that only follows a person's target. */
  private misses({ arms, time: time_s }: Snapshot): Found[] {
    if (this.scene.task["kind"] !== "reach") return [];
    return arms.flatMap((arm, index) => {
      if (!isUnreachable(arm)) {
        this.away.delete(index);
        return [];
      }
      const since = this.away.get(index) ?? { since_s: time_s, told: false };
      this.away.set(index, since);
      if (since.told || time_s - since.since_s < REST_S) return [];
      since.told = true;
      const text = `by hand: target not reached, ${(1000 * arm.positionError).toFixed(0)} mm away: ${arm.notReached ?? "unreachable"}`;
      return [{ time_s, text, mark: "hand_failed" }];
    });
  }
}

/** Adds what it sees to the log of `store`, and to the marks of the timeline. */
export class Witness {
  private states: States | null = null;
  private run: string | null = null;
  private isRead = false;
  private last_s = -Infinity;
  private wasPaused: boolean | null = null;

  constructor(private readonly store: Store) {
    store.on("hello", ({ run }) => {
      if (this.run === run.id) return;
      this.run = run.id;
      this.forget();
    });
    store.on("scene", () => {
      this.states = null;
    });
    store.on("snapshot", (snapshot) => this.see(snapshot));
    store.on("status", () => this.follow());
    store.on("timeline", () => void this.read());
  }

  private forget(): void {
    this.states = null;
    this.isRead = false;
    this.last_s = -Infinity;
    this.wasPaused = null;
  }

  private see(snapshot: Snapshot): void {
    const { store } = this;
    const { scene, hello } = store;
    if (scene === null || hello === null || store.earlier !== null) return;
    if (!hello.live) return this.replay(snapshot.time);
    if ((snapshot.flags & FLAG.notLive) !== 0) return;
    this.states ??= new States(scene);
    this.tell(this.states.next(snapshot));
  }

  /** The lines of a recording come when they are played. */
  private replay(time_s: number): void {
    const { store } = this;
    const before = this.last_s;
    this.last_s = time_s;
    if (time_s <= before || time_s - before > LEAP_S) return;
    store.showOwn((line) => line.time_s > before && line.time_s <= time_s);
  }

  /** A pause or its end by somebody else than this page. */
  private follow(): void {
    const { store } = this;
    const { newest, hello, past } = store;
    if (hello?.live !== true || newest === null || past !== null) return;
    const isPaused = newest.pause_cause === "operator";
    const before = this.wasPaused;
    this.wasPaused = isPaused;
    if (before === null || before === isPaused || (!isPaused && newest.pause_cause !== "")) return;
    const text = `operator: ${isPaused ? "pause" : "resume"}`;
    const known = store.log.length;
    const time_s = store.snapshot?.time ?? 0;
    setTimeout(() => {
      // One pause may be told before its status, and has its time.
      const near = store.log.slice(Math.max(0, known - 5)).some((line) => line.text === text && Math.abs(line.time_s - time_s) < LEAP_S);
      if (!near && this.store.hello?.run.id === this.run) this.tell([{ time_s, text, mark: isPaused ? "hand" : null }]);
    }, TOLD_MS);
  }

  private tell(found: Found[]): void {
    if (found.length === 0) return;
    const epoch = this.store.timeline?.epochs.at(-1)?.epoch ?? null;
    this.store.addOwn(found.map((line) => ({ ...line, kind: "lifecycle", epoch })));
    for (const { text, mark } of found) if (mark === "drop") this.store.emit("notice", { text, bad: true });
  }

  /** Reads once what was recorded before the page saw it. */
  private async read(): Promise<void> {
    const { store, run } = this;
    const { timeline, snapshot, scene, hello, past } = store;
    if (this.isRead || timeline === null || snapshot === null || scene === null || hello === null || past !== null) return;
    this.isRead = true;
    const isReplay = !hello.live;
    const to_s = isReplay ? timeline.to_s : Math.min(snapshot.time, timeline.to_s);
    const span = { from_s: timeline.from_s, to_s, epoch: null };
    const snapshots = to_s - span.from_s < LEAST_READ_S ? [] : await snapshotsOf(span, READ_SAMPLES);
    if (this.run !== run) return;
    const states = new States(scene);
    const found = snapshots.flatMap((one) => states.next(one)).filter(({ time_s }) => !this.isTold(time_s));
    const isKnown = (name: string) => [...found, ...store.own].some(({ text }) => text.startsWith(`object lost: ${name} `));
    const earlier = isReplay ? [] : lostOf(scene, snapshot).filter((name) => !isKnown(name));
    found.push(...earlier.map((name) => ({ time_s: to_s, text: `object lost: ${name} fell out of the cell before this was recorded`, mark: null })));
    const epoch = store.timeline?.epochs.at(-1)?.epoch ?? null;
    store.addOwn(found.map((line) => ({ ...line, kind: "lifecycle", epoch })));
  }

  /** Whether the page saw that moment itself. */
  private isTold(time_s: number): boolean {
    return this.store.own.some((line) => Math.abs(line.time_s - time_s) < PULLED_S && line.mark !== null);
  }
}
