// An incident in words: the failure, the motion of the arms, repeated time, dropped objects.
import type { LogLine } from "../../net/protocol";

/** The last cycles of a process, as columns of the same length. */
export interface LoopTrace {
  process: string;
  generation: number[];
  tick: number[];
  at_ms: number[];
  late_us: number[];
  body_us: number[];
  overruns: [number, string][];
  values: Record<string, number[]>;
}

export interface Incident {
  number: number;
  what: string;
  also: string[];
  at: string;
  sim_time_s: number;
  demo: string;
  policy: string;
  seed: number;
  complete: boolean;
  events: { at_ms: number; what: string }[];
  loops: LoopTrace[];
  logs: { process: string; lines: string[] }[];
}

/** Lines of the log within this time after the failure are about it (s). */
const AFTERWARDS_S = 3;
/** A joint that moves slower than this is at rest (rad/s). */
const AT_REST = 0.02;
/** A tick (ms). */
const TICK_MS = 1;
/** Codes of `stop action`, by ipc-types. */
const STOPS: Record<number, string> = {
  3: "stopped on a ramp and held its position",
  4: "stopped on a ramp, then the brakes held it",
  5: "was stopped by its brakes at once",
};

/** Sentences about `incident`; `log` are the marked lines of the run, `arms` names. */
export function summary(incident: Incident, log: readonly LogLine[], arms: readonly string[]): string[] {
  return [
    `At ${incident.sim_time_s.toFixed(2)} s ${[incident.what, ...incident.also].join("; ")}.`,
    ...restarts(incident),
    ...arms.flatMap((name, arm) => motion(incident, name, arm)),
    ...incident.loops.flatMap(repeated),
    fallen(incident, log),
  ];
}

function restarts({ events, complete }: Incident): string[] {
  const back = events.filter(({ what }) => what.includes("works again"));
  if (back.length === 0)
    return [complete ? "No process worked again within a second." : "The second after it is not kept yet."];
  return back.map(({ at_ms, what }) => `${what.replace(/,.*/, "")} after ${at_ms.toFixed(0)} ms.`);
}

/** What the drives of an arm did after the failure, as physics measured it. */
function motion({ loops }: Incident, name: string, arm: number): string[] {
  const physics = loops.find(({ process }) => process === "physics");
  const action = physics?.values[`arm ${arm} stop action`];
  const speed = physics?.values[`arm ${arm} fastest joint (rad/s)`];
  if (physics === undefined || action === undefined || speed === undefined) return [];
  const after = physics.at_ms.flatMap((at_ms, index) => (at_ms >= 0 ? [index] : []));
  const stopped = after.filter((index) => (action[index] ?? 0) !== 0);
  const first = stopped[0];
  if (first === undefined) {
    const moved = after.some((index) => (speed[index] ?? 0) > AT_REST);
    return [moved ? `${name} moved on without a stop.` : `${name} was at rest.`];
  }
  const last = stopped.at(-1) ?? first;
  const how = STOPS[action[first] ?? 0] ?? "stopped";
  const lasted_ms = (physics.at_ms[last] ?? 0) - (physics.at_ms[first] ?? 0);
  return [`${name} ${how}${last === after.at(-1) ? "" : ` for ${lasted_ms.toFixed(0)} ms`}.`];
}

/** A successor that resumed from an earlier tick repeats what follows it. */
function repeated({ process, generation, tick }: LoopTrace): string[] {
  return generation.flatMap((start, index) => {
    const before = tick[index - 1];
    if (before === undefined || generation[index - 1] === start) return [];
    const back_ms = (before - (tick[index] ?? before)) * TICK_MS;
    if (back_ms <= 0) return [];
    return [`${process} resumed from a state ${(back_ms / 1000).toFixed(2)} s earlier: that time is repeated.`];
  });
}

function fallen({ sim_time_s }: Incident, log: readonly LogLine[]): string {
  const isNear = (time_s: number) => time_s >= sim_time_s && time_s <= sim_time_s + AFTERWARDS_S;
  const near = log.filter(({ mark, time_s }) => mark === "drop" && isNear(time_s));
  return near.length === 0 ? "Nothing was dropped." : near.map(({ text }) => `${text}.`).join(" ");
}
