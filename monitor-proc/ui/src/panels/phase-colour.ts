// One colour per phase, in the strip of the graph and in the lanes of the timeline.
import type { Store } from "../net/store";

/** Hues that are told apart, by the order in which phases come up. */
const HUES = [210, 145, 35, 285, 180, 60, 320, 95, 250];
/** Of a phase in which the job has failed: no other phase is red. */
const FAILED_HUE = 0;
const known = new Map<string, number>();

/** Gives out the hues in the order in which the phases of a job came up, so that they are the same after a reload and in a
 * replay. To be called before anything is drawn. */
export function orderHues(store: Store): void {
  let demo: string | null = null;
  store.on("scene", (scene) => {
    if (scene.demo !== demo) known.clear();
    demo = scene.demo;
  });
  store.on("lanes", (spans) => {
    for (const { kind, label } of spans) if (kind === "phase" && label !== "") phaseHue(label);
  });
}

/** Hue of a phase (degrees). */
export function phaseHue(phase: string): number {
  if (/fail/i.test(phase)) return FAILED_HUE;
  const hue = known.get(phase) ?? HUES[known.size % HUES.length] ?? 0;
  known.set(phase, hue);
  return hue;
}
