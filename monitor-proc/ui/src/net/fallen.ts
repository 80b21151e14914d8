// Objects that fell out of the cell and that a device can bring again: physics parks them, as if they were never there.
import type { Scene } from "./protocol";
import { OBJECT, type Snapshot } from "./snapshot";

/** The state of an object and the count of physics are told within this time of each other (ms). */
const SAME_MS = 1500;
/** A longer step of simulated time was not followed (s). */
const LEAP_S = 5;

interface Gone {
  name: string;
  time_s: number;
  at_ms: number;
}

export interface Fall {
  name: string;
  time_s: number;
}

export class Falls {
  private here = new Set<string>();
  private last_s = -Infinity;
  /** Objects that left the cell; a reset takes them out of it as well. */
  private gone: Gone[] = [];
  private cleared: number | null = null;
  /** When physics counted an object that fell (ms). */
  private counted: number[] = [];
  /** Names of those that are still out, with the time at which they fell (s). */
  readonly out = new Map<string, number>();

  /** Takes a state, at `now_ms` of the page's clock. */
  see(scene: Scene, { objects, time }: Snapshot, now_ms: number): Fall[] {
    const parked = scene.objects.flatMap(({ name, parked }, index) =>
      parked === true && ((objects[index]?.flags ?? 0) & OBJECT.enabled) !== 0 ? [name] : [],
    );
    const here = new Set(parked);
    const isFollowed = time >= this.last_s && time - this.last_s < LEAP_S;
    this.last_s = time;
    if (!isFollowed) this.forget();
    else for (const name of this.here) if (!here.has(name)) this.gone.push({ name, time_s: time, at_ms: now_ms });
    this.here = here;
    for (const name of here) this.out.delete(name);
    return this.matched(now_ms);
  }

  /** Takes how many objects physics put away since the last reset. */
  count(cleared: number, now_ms: number): Fall[] {
    const before = this.cleared;
    this.cleared = cleared;
    if (before !== null && cleared < before) this.forget();
    const more = before === null ? 0 : Math.max(0, cleared - before);
    for (let one = 0; one < more; one++) this.counted.push(now_ms);
    return this.matched(now_ms);
  }

  private forget(): void {
    [this.gone, this.counted] = [[], []];
    this.out.clear();
  }

  /** Those that left and were counted. */
  private matched(now_ms: number): Fall[] {
    this.gone = this.gone.filter(({ at_ms }) => now_ms - at_ms < SAME_MS);
    this.counted = this.counted.filter((at_ms) => now_ms - at_ms < SAME_MS);
    const count = Math.min(this.gone.length, this.counted.length);
    this.counted.splice(0, count);
    const falls = this.gone.splice(0, count).map(({ name, time_s }) => ({ name, time_s }));
    for (const { name, time_s } of falls) this.out.set(name, time_s);
    return falls;
  }
}
