// Keeps the picture moving where there is no GPU: steps down when frames take
// too long, and up again after a long calm.

/** How shadows are cast. */
export interface Shadows {
  /** Width and height of the map (pixels). */
  map: number;
  /** Redrawn at most so often (ms). */
  everyMs: number;
}

export interface Level {
  name: string;
  multisample: boolean;
  shadows: Shadows | null;
  /** Physically based materials with reflections, and a second light. */
  fine: boolean;
  /** Shapes with few facets. */
  coarse: boolean;
  /** Of the screen's own pixels. */
  pixels: number;
  /** Pixels per pixel of the style sheet, at most. */
  densest: number;
}

const FINE_SHADOWS: Shadows = { map: 2048, everyMs: 0 };
const FEW_SHADOWS: Shadows = { map: 1024, everyMs: 100 };
const FINE = { multisample: true, shadows: FINE_SHADOWS, fine: true, coarse: false };
const FULL: Level = { name: "full", ...FINE, pixels: 1, densest: 2 };
const PLAIN: Level = { ...FULL, multisample: false, shadows: FEW_SHADOWS, fine: false };
const BARE: Level = { ...PLAIN, shadows: null, coarse: true };

/** Once nothing moves, with a graphics card. */
const AT_REST: Level = { ...FULL, name: "full, at rest", densest: Infinity };
/** Without one: light and materials are those of the moving picture, so that the room does not change when a motion ends.
 * Four points are drawn for each pixel. */
const PLAIN_AT_REST: Level = { ...PLAIN, name: "full, at rest", shadows: FINE_SHADOWS, pixels: 2, densest: Infinity };

/** How the picture is drawn once nothing moves. */
export function atRest(isSoftware: boolean): Level {
  return isSoftware ? PLAIN_AT_REST : AT_REST;
}

/** From the best to the fastest. */
export const LEVELS: readonly Level[] = [
  FULL,
  { ...FULL, name: "no antialiasing", multisample: false },
  { ...PLAIN, name: "plain light" },
  { ...PLAIN, name: "plain shapes", coarse: true },
  { ...BARE, name: "plain shapes, no shadows" },
  { ...BARE, name: "3/4 resolution", pixels: 0.75 },
  { ...BARE, name: "1/2 resolution", pixels: 0.5 },
];

/** Without a graphics card the ladder starts at plain light. */
export const SOFTWARE_LEVEL = 2;

const SLOW_MS = 40;
/** A level of less resolution is blurred: it is for less than 10 pictures a second only. */
const BLUR_MS = 100;
const FAST_MS = 20;
const WINDOW = 40;
/** Few but very slow frames are enough to judge. */
const IMPATIENT_MS = 1500;
const FEWEST = 6;
/** The first frames of a level compile its programs. */
const WARM_UP = 5;
/** The picture at rest may still be under way. */
const AFTER_REST = 3;
/** So many fluent frames, and the next better level is tried; four times as many
 * after each try that was too slow. */
const CALM_FRAMES = 300;
const MOST_CALM_FRAMES = 20_000;
/** A level that is too slow within so many frames was not worth the try. */
const TRIAL_FRAMES = 600;

function median(values: number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.floor(sorted.length / 2)] ?? 0;
}

export class Quality {
  /** Median time of a frame (ms), over the last frames that were measured. */
  frameMs = 0;
  private times: number[] = [];
  private calm = 0;
  private fresh = WARM_UP;
  private patience = CALM_FRAMES;
  /** Frames since a better level was tried. */
  private tried = Infinity;

  private readonly best: number;

  /** `fixed`: stay at this level whatever frames take; otherwise no level better
   * than the first is tried. */
  constructor(
    private index: number,
    readonly fixed: boolean,
    private readonly changed: (level: Level) => void,
  ) {
    this.best = index;
  }

  get level(): Level {
    return LEVELS[this.index] ?? (LEVELS[0] as Level);
  }

  /** 0 is the best. */
  get step(): number {
    return this.index;
  }

  /** The next frames also pay for something else. */
  skip(): void {
    this.fresh = Math.max(this.fresh, AFTER_REST);
  }

  /** Takes the time between two frames of which the second was drawn at once (ms). */
  frame(ms: number): void {
    if (this.fresh > 0) {
      this.fresh -= 1;
      return;
    }
    this.times.push(ms);
    const total = this.times.reduce((sum, time) => sum + time, 0);
    const enough = this.times.length >= FEWEST && total > IMPATIENT_MS;
    if (this.times.length < WINDOW && !enough) return;
    this.frameMs = median(this.times);
    this.judge(this.times.length);
    this.times = [];
  }

  private judge(frames: number): void {
    if (this.fixed) return;
    this.calm = this.frameMs < FAST_MS ? this.calm + frames : 0;
    this.tried += frames;
    const last = LEVELS.length - 1;
    const slow = (LEVELS[this.index + 1]?.pixels ?? 1) < 1 ? BLUR_MS : SLOW_MS;
    if (this.frameMs > slow && this.index < last) {
      if (this.tried < TRIAL_FRAMES) this.patience = Math.min(4 * this.patience, MOST_CALM_FRAMES);
      this.tried = Infinity;
      const far = this.frameMs > 4 * SLOW_MS && this.index < SOFTWARE_LEVEL;
      this.go(this.index + (far ? 2 : 1));
    } else if (this.calm > this.patience && this.index > this.best) {
      this.tried = 0;
      this.go(this.index - 1);
    }
  }

  private go(index: number): void {
    this.index = Math.min(Math.max(index, 0), LEVELS.length - 1);
    this.fresh = WARM_UP;
    this.calm = 0;
    this.changed(this.level);
  }
}
