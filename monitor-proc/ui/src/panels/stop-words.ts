// The codes of StopAction and StopCause (ipc-types/src/arm.rs), in words.

export interface StopWords {
  name: string;
  about: string;
  /** `ok`, `warn` or `bad`. */
  tone: "ok" | "warn" | "bad";
}

const ACTIONS: StopWords[] = [
  { name: "Normal", about: "in normal operation", tone: "ok" },
  { name: "Warning", about: "in normal operation, with something to report", tone: "warn" },
  { name: "Slow", about: "at reduced speed", tone: "warn" },
  { name: "Hold", about: "motion ends on a ramp, drives stay on, the gripper keeps its grip", tone: "warn" },
  { name: "Stop 1", about: "ramp down, then drives off and brakes", tone: "bad" },
  { name: "Stop 0", about: "drives off at once, brakes", tone: "bad" },
];

/** By code; nothing is said of the first, which is none. */
const CAUSES = [
  "",
  "no decision of the task in time",
  "no state of physics in time",
  "no command of the controller in time",
  "several messages were refused",
  "measured joints are far from the command",
  "the simulation or the operator paused",
  "the engine had to disable a body of the arm",
  "too many cycles were missed",
];

/** What 16 bits of a snapshot say: the action in the low byte, its cause, where it is told, in the high one. */
export function stopWords(code: number): StopWords {
  const action = ACTIONS[code & 0xff];
  if (action === undefined) {
    return { name: `Stop code ${code}`, about: "not known to this page", tone: "bad" };
  }
  const cause = CAUSES[code >>> 8] ?? `cause ${code >>> 8}`;
  return cause === "" ? action : { ...action, about: `${cause}; ${action.about}` };
}
