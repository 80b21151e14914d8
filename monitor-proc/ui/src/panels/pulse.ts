// Ten times a second at most: snapshots come sixty times, and no one reads
// numbers that fast.

const PERIOD_MS = 100;

export class Pulse {
  private all: { element: Element | null; run: () => void; seen: boolean }[] = [];

  constructor() {
    setInterval(() => this.beat(), PERIOD_MS);
  }

  /** Calls `run` while `element` (if given) is shown, until it leaves the page. */
  add(element: Element | null, run: () => void): void {
    this.all.push({ element, run, seen: false });
  }

  private beat(): void {
    if (document.hidden) return;
    this.all = this.all.filter((one) => {
      if (one.element === null || one.element.isConnected) one.seen = true;
      else return !one.seen;
      return true;
    });
    // All are asked before one writes: a question after a change computes the style of the page again.
    const shown = this.all.filter(({ element }) => element === null || element.checkVisibility());
    for (const { run } of shown) run();
  }
}
