// Tells when neither the cell nor the camera has moved for a while.

const REST_MS = 300;

export class Rest {
  /** Whether nothing moves. */
  reached = false;
  private timer = 0;

  /** `came` is called once each time rest is reached. */
  constructor(private readonly came: () => void) {}

  /** Something moved just now. */
  stir(): void {
    this.reached = false;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => {
      this.reached = true;
      this.came();
    }, REST_MS);
  }
}
