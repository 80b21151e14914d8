// One colour per phase, in the strip of the graph and in the lanes of the timeline.

/** Hues that are told apart, by the order in which phases come up. */
const HUES = [210, 145, 35, 285, 180, 60, 320, 95, 250];
/** Of a phase in which the job has failed: no other phase is red. */
const FAILED_HUE = 0;
const known = new Map<string, number>();

/** Hue of a phase (degrees), the same for the life of the page. */
export function phaseHue(phase: string): number {
  if (/fail/i.test(phase)) return FAILED_HUE;
  const hue = known.get(phase) ?? HUES[known.size % HUES.length] ?? 0;
  known.set(phase, hue);
  return hue;
}
