// One colour per phase, in the strip of the graph and in the lanes of the timeline: it depends on the name, so that it
// is the same in every run, after a reload and in a replay.
import type { Store } from "../net/store";

/** Of usual names and first words (degrees): phases that follow each other are far apart. Red and green are of failed and done. */
const BY_HUE: [number, string][] = [
  [25, "transport carry orient"],
  [35, "work attach bring"],
  [45, "grasp close"],
  [70, "detach retract up leave wait"],
  [195, "lower over put place placing"],
  [200, "reach"],
  [210, "above approach"],
  [215, "standby idle home rest follow"],
  [240, "hold stay move"],
  [265, "picking pick pre_grasp descend down fetch"],
  [285, "lift timed"],
  [290, "holding"],
  [320, "acquire flipping swing turn"],
  [325, "release open open_gripper"],
];
const USUAL = new Map(BY_HUE.flatMap(([hue, names]) => names.split(" ").map((name) => [name, hue] as const)));
/** Of other names. */
const HUES = [25, 50, 75, 180, 200, 220, 240, 260, 280, 300, 320];
const FAILED = "hsl(0 55% 32%)";
const DONE = "hsl(150 45% 25%)";
/** Hues of the names of the job that have none of their own. */
let others = new Map<string, number>();

/** Keeps apart the colours of the names in the graphs of a job. To be called before anything is drawn. */
export function tellPhasesApart(store: Store): void {
  store.on("graphs", (graphs) => {
    const all = new Set(graphs.flatMap(({ nodes }) => nodes.map(({ name }) => keyOf(name))));
    const names = [...all].filter((name) => usual(name) === undefined);
    others = new Map();
    // A job of more has no colour for each.
    if (names.length > HUES.length) return;
    // In the order of the alphabet: a graph may be told in another one.
    for (const name of names.sort()) {
      let at = slotOf(name);
      while ([...others.values()].includes(HUES[at] ?? 0)) at = (at + 1) % HUES.length;
      others.set(name, HUES[at] ?? 0);
    }
  });
}

/** `pre_grasp` of `PRE_GRASP`, `reach_to_pick` of `ReachToPick`, `pick_red` of `pick[red]`. */
function keyOf(name: string): string {
  const spaced = name.replace(/([a-z])([A-Z])/g, "$1_$2");
  return spaced.toLowerCase().replace(/[^a-z0-9]+/g, "_");
}

function usual(key: string): number | undefined {
  return USUAL.get(key) ?? USUAL.get(key.split("_")[0] ?? "");
}

/** A place in `HUES` that depends on the name alone. */
function slotOf(name: string): number {
  let hash = 0;
  for (const letter of name) hash = (hash * 31 + (letter.codePointAt(0) ?? 0)) % 65_521;
  return hash % HUES.length;
}

export function phaseColour(phase: string): string {
  const name = keyOf(phase);
  if (/fail/.test(name)) return FAILED;
  if (/^(done|complete|finished)$/.test(name)) return DONE;
  const hue = usual(name) ?? others.get(name) ?? HUES[slotOf(name)] ?? 0;
  return `hsl(${hue} 45% 28%)`;
}
