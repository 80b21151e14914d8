// Ten times a second at most: snapshots come sixty times, and nobody reads
// numbers that fast.

const PERIOD_MS = 100;

export class Pulse {
  private readonly all: { element: Element | null; run: () => void }[] = [];

  constructor() {
    setInterval(() => this.beat(), PERIOD_MS);
  }

  /** Calls `run` while `element` (if given) is shown. */
  add(element: Element | null, run: () => void): void {
    this.all.push({ element, run });
  }

  private beat(): void {
    if (document.hidden) return;
    for (const { element, run } of this.all) {
      if (element === null || element.checkVisibility()) run();
    }
  }
}
