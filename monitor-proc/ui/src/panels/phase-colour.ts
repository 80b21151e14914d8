// One colour per phase, in the strip of the graph and in the lanes of the timeline: it depends on the name, so that it
// is the same in every run, after a reload and in a replay.
import type { Store } from "../net/store";

/** Of usual names and first words (degrees): phases that follow each other are far apart. Red and green are of failed and done. */
const USUAL: Record<string, number> = {
  standby: 215, idle: 215, home: 215, rest: 215, hold: 240, follow: 215, stay: 240, work: 35,
  above: 210, approach: 210, picking: 265, pick: 265, pre_grasp: 265, descend: 265, down: 265, acquire: 320,
  grasp: 45, attach: 35, lift: 285, flipping: 320, fetch: 265, bring: 35,
  transport: 25, carry: 25, lower: 195, over: 195, put: 195, place: 195, placing: 195,
  release: 325, open: 325, detach: 70, holding: 290, retract: 70, up: 70, leave: 70,
  wait: 70, reach: 200, timed: 285, orient: 25, move: 240, swing: 320, turn: 320, open_gripper: 325, close: 45,
};
/** Of other names. */
const HUES = [25, 50, 75, 180, 200, 220, 240, 260, 280, 300, 320];
const FAILED = "hsl(0 55% 32%)";
const DONE = "hsl(150 45% 25%)";
/** Hues of the names of the job that have none of their own. */
let others = new Map<string, number>();

/** Keeps apart the colours of the names in the graphs of a job. To be called before anything is drawn. */
export function tellPhasesApart(store: Store): void {
  store.on("graphs", (graphs) => {
    const names = [...new Set(graphs.flatMap(({ nodes }) => nodes.map(({ name }) => keyOf(name))))].filter((name) => usual(name) === undefined);
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
  return name.replace(/([a-z])([A-Z])/g, "$1_$2").toLowerCase().replace(/[^a-z0-9]+/g, "_");
}

function usual(key: string): number | undefined {
  return USUAL[key] ?? USUAL[key.split("_")[0] ?? ""];
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
