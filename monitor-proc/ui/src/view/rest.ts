// Tells when neither the cell nor the camera has moved for a while.

const REST_MS = 300;

export class Rest {
  /** Whether nothing moves. */
  reached = false;
  private timer = 0;

  /** `came` is called once each time rest is reached; not while `unsure` says that
   * nothing was heard since the last motion. */
  constructor(
    private readonly unsure: () => boolean,
    private readonly came: () => void,
  ) {}

  /** Something moved just now. */
  stir(): void {
    this.reached = false;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => {
      if (this.unsure()) {
        this.stir();
        return;
      }
      this.reached = true;
      this.came();
    }, REST_MS);
  }
}
