// The state of the cell in one line: the first of these that is true.
import type { Hello, Status } from "../../net/protocol";
import { words } from "../format";

/** What the line is told from. */
export interface Facts {
  connected: boolean;
  /** The monitor refused the page: its link belongs to another run. */
  refused: boolean;
  hello: Hello | null;
  /** Clock time of the last message (ms); null while there was none. */
  heard_ms: number | null;
  /** Clock time (ms). */
  now_ms: number;
  /** The monitor said that the cell has ended. */
  ended: boolean;
  task: Status["task"] | null;
  /** Simulated time that is shown, and the newest one (s). */
  shown_s: number;
  newest_s: number;
  /** Whether a moment of the past is shown. */
  past: boolean;
  /** Seed of the run that this moment is of, where that run has ended and another one began. */
  earlierSeed: number | null;
  paused: boolean;
  pauseCause: string;
  taskPaused: boolean;
  /** Whether the task begins with a start event. */
  startEvent: boolean;
  /** What each arm holds, as a sentence without a subject where there is one arm. */
  held: string[];
  /** What keeps an arm from the target that a person gave it; empty if nothing does. */
  unreached: string;
  /** Names of objects that fell out of the cell. */
  lost: string[];
  incidents: number;
}

export type Action = "again" | "moment" | "play" | "resume" | "start";

export interface Line {
  tone: "ok" | "info" | "warn" | "bad" | "stale";
  /** One or two words. */
  state: string;
  detail: string;
  /** What starts the cell again. */
  command: string | null;
  actions: Action[];
}

/** More names of objects do not fit. */
const MOST_NAMES = 3;
/** A monitor that restarts answers within this time (ms). */
const RESTART_MS = 5000;

const line = (tone: Line["tone"], state: string, detail: string, ...actions: Action[]): Line => ({ tone, state, detail, command: null, actions });

export function lineOf(facts: Facts): Line {
  return connection(facts) ?? source(facts) ?? clock(facts) ?? task(facts);
}

function clockTime(ms: number): string {
  return new Date(ms).toTimeString().slice(0, 8);
}

function connection({ connected, refused, hello, heard_ms, now_ms, ended }: Facts): Line | null {
  if (refused) {
    return { ...line("bad", "Wrong link", "this page belongs to a run that has ended; the link of the one that runs now is printed by"), command: "robocell status" };
  }
  if (connected) return null;
  if (hello === null || heard_ms === null) return line("info", "Connecting", "no message of the monitor yet");
  const at = clockTime(heard_ms);
  if (!ended && now_ms - heard_ms < RESTART_MS) return line("warn", "No answer", `the monitor has not answered since ${at}; the page connects again`);
  const { demo, policy, seed } = hello.run;
  const command = hello.live ? `robocell run ${demo} --policy ${policy} --seed ${seed}` : `robocell replay ${hello.source ?? "FILE"}`;
  const what = hello.live ? "The cell" : "The replay";
  const since = ended ? `at ${at}` : `no process has answered since ${at}`;
  const detail = `${since}; the page shows that moment. This starts it again:`;
  return { ...line("stale", `${what} has ended`, detail), command };
}

/** A recording, or a moment of the past. */
function source({ hello, past, earlierSeed, shown_s, newest_s, incidents }: Facts): Line | null {
  if (hello?.live === false) {
    const count = incidents === 0 ? "" : `, ${incidents} ${incidents === 1 ? "incident" : "incidents"}`;
    return line("info", "Replay", `${hello.source ?? hello.run.demo}: ${shown_s.toFixed(1)} s of ${newest_s.toFixed(1)} s${count}`);
  }
  if (past && earlierSeed !== null) return line("warn", "Past", `${shown_s.toFixed(2)} s of seed ${earlierSeed}, whose run has ended`);
  if (past) return line("warn", "Past", `${shown_s.toFixed(2)} s, ${Math.max(0, newest_s - shown_s).toFixed(1)} s before now`);
  return null;
}

function clock({ paused, pauseCause, task }: Facts): Line | null {
  // The reason of a failure is said also where the clock was paused after it.
  if (!paused || task?.outcome === "failed" || task?.outcome === "done") return null;
  return line("warn", "Paused", pauseCause, "play");
}

function task({ task, taskPaused, startEvent, held, unreached, lost, paused }: Facts): Line {
  if (task === null) return line("info", "Starting", "no decision of the task yet");
  if (task.outcome === "failed") return line("bad", "Failed", failed(task, lost), "again", "moment");
  if (taskPaused) return line("warn", "Task paused", "you lead the arm and the gripper", "resume");
  if (task.outcome === "done") return line("ok", "Done", [finished(task), ...(paused ? ["the clock is paused"] : [])].filter((part) => part !== "").join(" · "), "again");
  const idle = task.outcome === "idle";
  if (startEvent && !task.started) return line("info", "Waiting", "for the start event", "start");
  if (task.wait !== "") return line("warn", "Waiting", task.wait);
  const phase = words(task.phase);
  if (idle) return line("info", "Idle", phase);
  // A task that knows of no loss tries for ever.
  const wrong = [...outside(lost), unreached].filter((what) => what !== "");
  return line(wrong.length > 0 ? "warn" : "ok", "Running", [phase, ...held, ...wrong].join(" · "));
}

/** Names the objects that fell out of the cell, if any. */
function outside(names: string[]): string[] {
  if (names.length === 0) return [];
  const more = names.length > MOST_NAMES ? ` and ${names.length - MOST_NAMES} more` : "";
  return [`out of the cell: ${names.slice(0, MOST_NAMES).join(", ")}${more}`];
}

/** Why it failed; with the objects that are lost, where the reason names none of them. */
function failed({ reason }: Status["task"], lost: string[]): string {
  const why = words(reason) || "no reason is known";
  return [why, ...outside(lost.filter((name) => !reason.includes(name)))].join(" · ");
}

/** What a task that is done has done, and what went wrong on the way. */
function finished({ placed, drops }: Status["task"]): string {
  const counts: [number, string][] = [[placed.length, "object placed"], [drops, "drop on the way"]];
  return counts.flatMap(([count, what]) => (count === 0 ? [] : [counted(count, what)])).join(", ");
}

/** `1 object placed`, `2 objects placed`. */
function counted(count: number, what: string): string {
  const [noun = "", ...rest] = what.split(" ");
  return [count, count === 1 ? noun : `${noun}s`, ...rest].join(" ");
}
