// Draws at most once per frame of the browser, and only when asked to.

export class Frames {
  /** Pictures drawn so far. */
  drawn = 0;
  private asked = false;
  private pending = 0;
  private drawnAt: number | null = null;

  /** `draw` draws and answers whether that counts: `took` gets the time from such a
   * frame to the next tick (ms). */
  constructor(
    private readonly draw: () => boolean,
    private readonly took: (ms: number) => void,
  ) {
    document.addEventListener("visibilitychange", () => {
      this.drawnAt = null;
      if (!document.hidden && this.asked) this.schedule();
    });
  }

  /** Asks for a new picture. */
  ask(): void {
    this.asked = true;
    if (!document.hidden) this.schedule();
  }

  /** Draws before the browser shows its next frame, in which an empty picture would be visible. */
  now(): void {
    this.asked = false;
    this.drawnAt = null;
    this.drawn += 1;
    this.draw();
  }

  private schedule(): void {
    if (this.pending === 0) this.pending = requestAnimationFrame((now) => this.tick(now));
  }

  private tick(now: number): void {
    this.pending = 0;
    if (this.drawnAt !== null) this.took(now - this.drawnAt);
    this.drawnAt = null;
    if (!this.asked) return;
    this.asked = false;
    this.drawn += 1;
    if (!this.draw()) return;
    this.drawnAt = now;
    // One tick more than needed: it tells what this picture cost.
    this.schedule();
  }
}
