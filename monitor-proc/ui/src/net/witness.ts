// Events that no process reports, derived from the states: an object that fell out of the cell, an object pulled by a
// person, a target that is not reached, the end of a task that logs nothing.
import type { Fall } from "./fallen";
import { lostOf } from "./lost";
import { snapshotsOf } from "./past";
import type { LogLine, Scene } from "./protocol";
import { FLAG, isUnreachable, OBJECT, type Snapshot } from "./snapshot";
import type { Store } from "./store";
import { fallenText, lostText, NOT_REACHED, OBJECT_LOST, type Wrong, type WrongFrom } from "./wrong";

/** An object that was let go for less is still pulled (simulated s). */
const PULLED_S = 1;
/** An arm has to be at rest, or not, for so long (simulated s). */
const REST_S = 0.5;
/** States of what was recorded before, and their least length (s). */
const READ_SAMPLES = 400;
const LEAST_READ_S = 1;
/** What a task says of its end comes within this time (ms). */
const TOLD_MS = 200;
/** A replay that leaps farther was not played (s). */
const LEAP_S = 1;
/** The task tells of its end within this time of it (s). */
const END_S = 0.5;
/** Marks of the ends of a task. */
const ENDS: Record<string, string | undefined> = { done: "done", failed: "fault" };

type Found = Pick<LogLine, "time_s" | "text" | "mark">;

interface Seen {
  lines: Found[];
  /** States that begin. */
  wrong: WrongFrom[];
}

/** An arm that rests away from its target. */
interface Away {
  since_s: number;
  told: boolean;
  /** When it began to move again. */
  left_s?: number;
}

/** Follows states one after the other. */
class States {
  private lost = new Set<string>();
  /** By object: when it was pulled last (s). */
  private readonly pulled = new Map<string, number>();
  /** By arm. */
  private away = new Map<number, Away>();
  /** When an arm began to move that had rested away from its target (s). */
  private left_s = -Infinity;
  private wrong: Wrong = "";
  private time_s = -Infinity;

  constructor(private readonly scene: Scene) {}

  /** What happened since the state before. */
  next(snapshot: Snapshot): Seen {
    const isFirst = this.time_s === -Infinity;
    const time_s = snapshot.time;
    // Physics was restarted, or the scene reset.
    if (time_s < this.time_s) [this.away, this.wrong] = [new Map(), ""];
    this.time_s = time_s;
    const lost = lostOf(this.scene, snapshot);
    const fell = isFirst ? [] : lost.filter((name) => !this.lost.has(name));
    this.lost = new Set(lost);
    const lines = fell.map((name): Found => ({ time_s, text: lostText(name), mark: "drop" }));
    lines.push(...this.pulls(snapshot), ...this.misses(snapshot));
    return { lines, wrong: this.begun(time_s, isFirst) };
  }

  private begun(time_s: number, isFirst: boolean): WrongFrom[] {
    const missed = [...this.away.values()].filter(({ told }) => told).map(({ since_s }) => since_s);
    const label = this.lost.size > 0 ? OBJECT_LOST : missed.length > 0 ? NOT_REACHED : "";
    if (label === this.wrong && !isFirst) return [];
    const before = this.wrong;
    this.wrong = label;
    if (label === NOT_REACHED) return [{ from_s: Math.min(...missed), label }];
    const isLeft = label === "" && before === NOT_REACHED;
    return [{ from_s: isLeft ? this.left_s : time_s, label }];
  }

  private pulls({ objects, time: time_s }: Snapshot): Found[] {
    const found: Found[] = [];
    for (const [index, { flags }] of objects.entries()) {
      const name = this.scene.objects[index]?.name;
      if ((flags & OBJECT.dragged) === 0 || name === undefined) continue;
      const before = this.pulled.get(name);
      this.pulled.set(name, time_s);
      if (before === undefined || Math.abs(time_s - before) > PULLED_S)
        found.push({ time_s, text: `by hand: ${name} is pulled`, mark: "hand" });
    }
    return found;
  }

  /** Of a task that only follows a person's target. */
  private misses({ arms, time: time_s }: Snapshot): Found[] {
    if (this.scene.task.kind !== "reach") return [];
    return arms.flatMap((arm, index) => {
      const known = this.away.get(index);
      if (!isUnreachable(arm)) {
        if (known !== undefined) this.leave(index, known, time_s);
        return [];
      }
      const since = known ?? { since_s: time_s, told: false };
      delete since.left_s;
      this.away.set(index, since);
      if (since.told || time_s - since.since_s < REST_S) return [];
      since.told = true;
      const text = `by hand: target not reached, ${(1000 * arm.positionError).toFixed(0)} mm away: ${arm.notReached ?? "unreachable"}`;
      // Of the time at which the lane of the outcome changes.
      return [{ time_s: since.since_s, text, mark: "hand_failed" }];
    });
  }

  /** Ends the state after `REST_S` of motion: an arm that creeps alternates between rest and motion. */
  private leave(index: number, away: Away, time_s: number): void {
    away.left_s ??= time_s;
    if (away.told && time_s - away.left_s < REST_S) return;
    this.left_s = away.left_s;
    this.away.delete(index);
  }
}

/** Adds these events to the log of `store`, and to the marks of the timeline. */
export class Witness {
  private states: States | null = null;
  private run: string | null = null;
  private isRead = false;
  private last_s = -Infinity;
  /** Ends of the task that were seen. */
  private ends = new Set<string>();

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
    store.on("status", () => {
      const cleared = store.past === null ? store.status?.equipment?.cleared : undefined;
      if (cleared !== undefined && store.earlier === null) this.fell(store.falls.count(cleared, performance.now()));
    });
    store.on("timeline", () => void this.read());
    store.on("lanes", () => this.end());
  }

  private forget(): void {
    this.states = null;
    this.isRead = false;
    this.last_s = -Infinity;
    this.ends = new Set();
  }

  private see(snapshot: Snapshot): void {
    const { store } = this;
    const { scene, hello } = store;
    if (scene === null || hello === null || store.earlier !== null) return;
    if (!hello.live) this.replay(snapshot.time);
    else if ((snapshot.flags & FLAG.notLive) !== 0) return;
    this.fell(store.falls.see(scene, snapshot, performance.now()));
    if (!hello.live) return;
    this.states ??= new States(scene);
    const isBack = snapshot.time < this.last_s;
    this.last_s = snapshot.time;
    const { lines, wrong } = this.states.next(snapshot);
    store.addWrong(wrong, isBack ? snapshot.time : Infinity);
    this.tell(lines);
  }

  private fell(falls: Fall[]): void {
    // Parts of a dispenser fall by the dozen.
    const isPart = this.store.scene?.dispenser != null;
    const text = (name: string) => (isPart ? `${name} is out of the cell` : fallenText(name));
    const mark = isPart ? null : "drop";
    const found = falls.map(({ name, time_s }): Found => ({ time_s, text: text(name), mark }));
    // A recording may be played twice.
    this.tell(found.filter((line) => !this.isTold(line)));
  }

  /** An end of which the task says nothing in words. */
  private end(): void {
    const { store, run } = this;
    for (const { kind, label, epoch, from_s } of store.spans) {
      const mark = kind === "task" ? ENDS[label] : undefined;
      const key = `${epoch} ${from_s}`;
      if (mark === undefined || this.ends.has(key)) continue;
      this.ends.add(key);
      setTimeout(() => {
        const isTold = store.marked.some((line) => line.mark === mark && Math.abs(line.time_s - from_s) < END_S);
        if (!isTold && this.run === run)
          store.addOwn([{ time_s: from_s, text: `[task] ${label}`, mark, kind: "lifecycle", epoch }]);
      }, TOLD_MS);
    }
  }

  /** The lines of a recording come when they are played. */
  private replay(time_s: number): void {
    const { store } = this;
    const before = this.last_s;
    this.last_s = time_s;
    if (time_s <= before || time_s - before > LEAP_S) return;
    store.showOwn((line) => line.time_s > before && line.time_s <= time_s);
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
    if (this.isRead || timeline === null || snapshot === null || past !== null) return;
    if (scene === null || hello === null) return;
    this.isRead = true;
    const isReplay = !hello.live;
    const to_s = isReplay ? timeline.to_s : Math.min(snapshot.time, timeline.to_s);
    const span = { from_s: timeline.from_s, to_s, epoch: null };
    const snapshots = to_s - span.from_s < LEAST_READ_S ? [] : await snapshotsOf(span, READ_SAMPLES);
    if (this.run !== run) return;
    const states = new States(scene);
    const seen = snapshots.map((one) => states.next(one));
    store.addWrong(seen.flatMap(({ wrong }) => wrong));
    const found = seen.flatMap(({ lines }) => lines).filter((line) => !this.isTold(line));
    const isKnown = (name: string) => [...found, ...store.own].some(({ text }) => text.startsWith(lostText(name)));
    const earlier = isReplay ? [] : lostOf(scene, snapshot).filter((name) => !isKnown(name));
    const text = (name: string) => `${lostText(name)} before this was recorded`;
    found.push(...earlier.map((name) => ({ time_s: span.from_s, text: text(name), mark: "drop" })));
    const epoch = store.timeline?.epochs.at(-1)?.epoch ?? null;
    store.addOwn(found.map((line) => ({ ...line, kind: "lifecycle", epoch })));
  }

  /** Whether the page saw it itself. */
  private isTold({ text, time_s }: Found): boolean {
    return this.store.own.some((line) => line.text === text && Math.abs(line.time_s - time_s) < PULLED_S);
  }
}
