// Which part of the recorded time the timeline shows: all, or what the wheel chose.

export interface TimeSpan {
  first: number;
  last: number;
}

const WHEEL_RATE = 0.002;
/** The shortest part (s). */
const LEAST_S = 0.5;

export class Zoom {
  private part: TimeSpan | null = null;

  /** The shown part of `all`, the recorded time. */
  of(all: TimeSpan): TimeSpan {
    if (this.part === null) return all;
    const first = Math.max(this.part.first, all.first);
    const last = Math.min(this.part.last, all.last);
    return last - first < LEAST_S ? all : { first, last };
  }

  get isZoomed(): boolean {
    return this.part !== null;
  }

  all(): void {
    this.part = null;
  }

  /** A turn of the wheel at `time`: zooms, or with `sideways` moves the part. */
  wheel(delta: number, sideways: boolean, time: number, all: TimeSpan): void {
    const { first, last } = this.of(all);
    if (sideways) return this.show(first + delta * WHEEL_RATE * (last - first), last - first, all);
    const length = Math.max((last - first) * Math.exp(WHEEL_RATE * delta), LEAST_S);
    this.show(time - ((time - first) * length) / (last - first), length, all);
  }

  private show(first: number, length: number, all: TimeSpan): void {
    if (length >= all.last - all.first) return this.all();
    const from = Math.min(Math.max(first, all.first), all.last - length);
    this.part = { first: from, last: from + length };
  }
}
