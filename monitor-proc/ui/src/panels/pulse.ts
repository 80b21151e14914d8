// Ten times a second at most: snapshots come sixty times, and no one reads
// numbers that fast.

const PERIOD_MS = 100;

export class Pulse {
  private measures: (() => void)[] = [];
  private waits = false;
  private all: { element: Element | null; run: () => void; seen: boolean }[] = [];

  constructor() {
    setInterval(() => this.beat(), PERIOD_MS);
  }

  /** Calls `run` while `element` (if given) is shown, until it leaves the page. */
  add(element: Element | null, run: () => void): void {
    this.all.push({ element, run, seen: false });
  }

  /** Calls `run` once, before anything of the next beat is written: it may ask for sizes at no cost. */
  measure(run: () => void): void {
    if (!this.measures.includes(run)) this.measures.push(run);
  }

  /** Updates all visible panels at once, without a wait for the next beat. */
  now(): void {
    this.ask()();
  }

  private beat(): void {
    // Pictures may come more slowly than beats.
    if (document.hidden || this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => this.behind());
  }

  /**
   * Reads after a frame of the browser, when style and layout are up to date, and writes in the next frame, in which the
   * 3D view shows the same moment.
   */
  private behind(): void {
    const begun_ms = performance.now();
    setTimeout(() => {
      const write = this.ask();
      requestAnimationFrame(() => {
        write();
        this.waits = performance.now() - begun_ms >= PERIOD_MS;
        if (this.waits) this.behind();
      });
    });
  }

  /** Reads sizes and visibility; returns the function that writes. */
  private ask(): () => void {
    const { measures } = this;
    this.measures = [];
    for (const run of measures) run();
    this.all = this.all.filter((one) => {
      if (one.element === null || one.element.isConnected) one.seen = true;
      else return !one.seen;
      return true;
    });
    // All are asked before one writes: a question after a change computes the style of the page again.
    const shown = this.all.filter(({ element }) => element === null || element.checkVisibility());
    return () => {
      for (const { run } of shown) run();
    };
  }
}
