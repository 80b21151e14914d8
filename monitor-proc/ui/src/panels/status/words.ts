// The state of the cell in one line: how the task is, and around it whether that is now, paused, past or over.
import type { Link } from "../../net/link";
import type { AfterDone } from "../../net/phases";
import type { Hello, Status } from "../../net/protocol";
import { PICKING_UP } from "../../net/wrong";
import { sentence, tenths, words } from "../format";

/** What the line is told from. */
export interface Facts {
  link: Link;
  hello: Hello | null;
  /** Clock time of the last message (ms); null while there was none. */
  heard_ms: number | null;
  task: Status["task"] | null;
  /** Phase at the moment that is shown. */
  phase: string;
  /** What a task that is done does since. */
  since: AfterDone;
  /** Whether a grip was lost and nothing is held since. */
  isPickingUp: boolean;
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
  /** Whether the task starts with a start event. */
  startEvent: boolean;
  /** What each arm holds, as a sentence without a subject where there is one arm. */
  held: string[];
  /** What keeps an arm from the target that a person gave it; empty if nothing does. */
  unreached: string;
  /** How far an arm is from the target that a person gave it; empty for other tasks. */
  target: string;
  /** Names of objects that fell out of the cell. */
  lost: string[];
  /** Names of those that fell out and that a device can bring again. */
  fallen: string[];
  incidents: number;
}

export type Action = "again" | "moment" | "play" | "reset" | "resume" | "start" | "tool";
type Tone = "ok" | "info" | "warn" | "bad" | "stale";

export interface Line {
  /** `done`: the task is done and nothing went wrong since. */
  tone: Tone | "done";
  /** One to four words. */
  state: string;
  detail: string;
  /** What starts the cell again. */
  command: string | null;
  actions: Action[];
}

/** How the task is. */
export interface Told {
  tone: Tone;
  word: string;
  /** Whether the word says more than that the task works: it is kept beside `Paused` and the like. */
  isSpecial: boolean;
  detail: string[];
  actions: Action[];
}

/** More names of objects do not fit. */
const MOST_NAMES = 3;
/** So many are told by their number. */
const MANY = 6;
/** A recording that is nearer to its end is over (s). */
const END_S = 0.05;

/** The parts that say something, as one text. */
export function joined(parts: string[]): string {
  return parts.filter((part) => part !== "").join(" · ");
}

function line(
  tone: Tone,
  state: string,
  detail: string[],
  actions: Action[] = [],
  command: string | null = null,
): Line {
  return { tone, state, detail: joined(detail), command, actions };
}

export function lineOf(facts: Facts): Line {
  const told = taskOf(facts);
  return connection(facts, told) ?? source(facts, told) ?? clock(facts, told) ?? now(told);
}

function now({ tone, word, detail, actions }: Told): Line {
  return { ...line(tone, word, detail, actions), ...(word === "Done" && tone === "ok" ? { tone: "done" } : {}) };
}

function clockTime(ms: number): string {
  return new Date(ms).toTimeString().slice(0, 8);
}

function connection(facts: Facts, told: Told): Line | null {
  const { link, hello, heard_ms } = facts;
  if (link === "refused") {
    const why = "this page belongs to a run that has ended; the link of the one that runs now is printed by";
    return line("bad", "Wrong link", [why], [], "robocell status");
  }
  if (link === "connected") return null;
  if (hello === null || heard_ms === null) return line("info", "Connecting", ["no message of the monitor yet"]);
  const [at, last] = [clockTime(heard_ms), stood(told, facts.paused)];
  if (link === "no answer") return line("warn", "No answer", [`since ${at}; the page connects again`, last]);
  const { command: typed, demo, policy, seed } = hello.run;
  const command = hello.live
    ? typed || `robocell run ${demo} --policy ${policy} --seed ${seed}`
    : `robocell replay ${hello.source ?? "FILE"}`;
  const what = hello.live ? "The cell" : "The replay";
  return line("stale", `${what} has ended`, [`at ${at}`, last, "this starts it again:"], [], command);
}

/** How the task was at the last moment that is known. */
function stood({ word, detail, isSpecial }: Told, isPaused: boolean): string {
  return joined([`the task was ${isPaused && !isSpecial ? "paused" : word.toLowerCase()}`, ...detail]);
}

/** A word and what the task did, for a moment that is not now. */
function around(told: Told, word: string): { state: string; detail: string[] } {
  if (told.isSpecial) return { state: `${word} · ${told.word.toLowerCase()}`, detail: told.detail };
  return { state: word, detail: told.word === "Running" ? told.detail : [told.word.toLowerCase(), ...told.detail] };
}

/** A recording, or a moment of the past. */
function source(facts: Facts, told: Told): Line | null {
  const { hello, past, earlierSeed, shown_s, newest_s, incidents } = facts;
  const { state, detail } = around(told, hello?.live === false ? "Replay" : "Past");
  if (hello?.live === false) {
    const count = incidents === 0 ? "" : `${incidents} ${incidents === 1 ? "incident" : "incidents"}`;
    const isOver = shown_s >= newest_s - END_S && newest_s > 0;
    const end = isOver ? (told.isSpecial ? "at its end" : "the recording ends here") : "";
    const time = `${tenths(shown_s)} of ${tenths(newest_s)}`;
    const parts = [...detail, end, time, count, hello.source ?? hello.run.demo];
    return line(told.tone === "bad" ? "bad" : "info", state, parts);
  }
  if (!past) return null;
  if (earlierSeed !== null)
    return line("warn", "Past", [`${shown_s.toFixed(2)} s of seed ${earlierSeed}, whose run has ended`]);
  const before_s = Math.max(0, newest_s - shown_s);
  return line("warn", state, [...detail, `${shown_s.toFixed(2)} s, ${before_s.toFixed(1)} s before now`]);
}

function clock({ paused, pauseCause }: Facts, told: Told): Line | null {
  if (!paused) return null;
  const { state, detail } = around(told, "Paused");
  const why = pauseCause === "by an operator" ? "paused by an operator" : pauseCause;
  const others = told.actions.filter((action) => action !== "start");
  return line(told.tone === "bad" ? "bad" : "warn", state, [...detail, why], ["play", ...others]);
}

/** How the task is at the moment shown: one word for bar, badge and title. */
export function taskOf(facts: Facts): Told {
  const { task, taskPaused, startEvent, held, unreached, lost, fallen, since } = facts;
  const told = (tone: Tone, word: string, detail: string[], actions: Action[] = [], isSpecial = true): Told => {
    return { tone, word, isSpecial, detail, actions };
  };
  if (task === null) return told("info", "Starting", ["no decision of the task yet"], [], false);
  if (task.outcome === "failed") return told("bad", "Failed", [failed(task, lost)], ["again", "moment"]);
  const phase = words(facts.phase);
  const wait = task.wait === "" ? phase : task.wait;
  // A task that does not notice a loss tries for ever.
  const isDone = task.outcome === "done" && !since.isAgain;
  if (lost.length > 0 && !isDone)
    return told("bad", "Object lost", [`${named(lost)}`, wait, ...held, taskPaused ? "task paused" : ""], ["reset"]);
  if (taskPaused) return told("warn", "Task paused", ["you lead the arm and the gripper", phase], ["resume"]);
  const gone = [...lost, ...fallen];
  if (isDone)
    return told(lost.length > 0 ? "warn" : "ok", "Done", [...finished(facts, task), ...outside(gone)], ["again"]);
  const again = () => told("warn", sentence(PICKING_UP), [phase, gripsLost(task), ...outside(gone)]);
  if (since.isPickingUp) return again();
  if (startEvent && !task.started) return told("info", "Waiting", ["for the start event"], ["start"], false);
  if (task.wait !== "") return told("warn", "Waiting", [task.wait, phase, ...held, gripsLost(task)], [], false);
  if (task.outcome === "idle") return told("info", "Idle", [phase], [], false);
  if (unreached !== "") return told("bad", "Not reached", [unreached, phase, ...held], ["tool"]);
  if (facts.isPickingUp) return again();
  return told("ok", "Running", [facts.target, phase, ...held, gripsLost(task), ...outside(fallen)], [], false);
}

function named(names: string[]): string {
  const more = names.length > MOST_NAMES ? ` and ${names.length - MOST_NAMES} more` : "";
  return `${names.slice(0, MOST_NAMES).join(", ")}${more}`;
}

/** Names the objects that fell out of the cell, if any; of a heap of parts the names say nothing. */
function outside(names: string[]): string[] {
  if (names.length > MANY) return [`out of the cell: ${counted(names.length, "object")}`];
  return names.length === 0 ? [] : [`out of the cell: ${named(names)}`];
}

/** Why it failed; with the objects that are lost, where the reason names none of them. */
function failed({ reason }: Status["task"], lost: string[]): string {
  const why = words(reason) || "no reason is known";
  return [why, ...outside(lost.filter((name) => !reason.includes(name)))].join(" · ");
}

/** What a task that is done has done, and how often it lost its grip on the way. */
function finished({ since, held }: Facts, task: Status["task"]): string[] {
  const { length } = task.placed;
  // An object that is held tells more than the sentence about the end, which may be older.
  return [length > 0 ? `${counted(length, "object")} placed` : held.join(", ") || since.achieved, gripsLost(task)];
}

function gripsLost({ drops }: Status["task"]): string {
  return drops > 0 ? `grip lost ${counted(drops, "time")}` : "";
}

/** `1 object`, `2 objects`. */
export function counted(count: number, noun: string): string {
  return `${count} ${count === 1 ? noun : `${noun}s`}`;
}
