// Tells when neither the cell nor the camera has moved for a while.

const REST_MS = 300;

export class Rest {
  /** Whether nothing moves. */
  reached = false;
  private timer = 0;
  private stirredAt = 0;

  /** `came` is called once each time rest is reached; not while `unsure` says that
   * nothing was heard since the last motion. */
  constructor(
    private readonly unsure: () => boolean,
    private readonly came: () => void,
  ) {}

  /** Something moved just now. */
  stir(): void {
    this.reached = false;
    this.stirredAt = performance.now();
    // One timer: snapshots come sixty times a second.
    if (this.timer === 0) this.wait(REST_MS);
  }

  private wait(ms: number): void {
    this.timer = window.setTimeout(() => this.look(), ms);
  }

  private look(): void {
    this.timer = 0;
    const left = this.stirredAt + REST_MS - performance.now();
    if (left > 0) return this.wait(left);
    if (this.unsure()) return this.wait(REST_MS);
    this.reached = true;
    this.came();
  }
}
