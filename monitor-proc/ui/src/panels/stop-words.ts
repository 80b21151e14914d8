// The codes of StopAction and StopCause (ipc-types/src/arm.rs), in words.

export interface StopWords {
  name: string;
  about: string;
  /** `ok`, `warn` or `bad`. */
  tone: "ok" | "warn" | "bad";
}

const ACTIONS: Record<number, StopWords> = {
  0: { name: "Normal", about: "in normal operation", tone: "ok" },
  3: { name: "Hold", about: "motion ends on a ramp, drives stay on, the gripper keeps its grip", tone: "warn" },
  4: { name: "Stop 1", about: "ramp down, then drives off and brakes", tone: "bad" },
  5: { name: "Stop 0", about: "drives off at once, brakes", tone: "bad" },
};

/** By code; nothing is said of the first, which is none. */
const CAUSES: Record<number, string> = {
  0: "",
  1: "no decision of the task in time",
  3: "no command of the controller in time",
  5: "measured joints are far from the command",
  7: "the engine had to disable a body of the arm",
};

/** What 16 bits of a snapshot say: the action in the low byte, its cause, where it is told, in the high one. */
export function stopWords(code: number): StopWords {
  const action = ACTIONS[code & 0xff];
  if (action === undefined) {
    return { name: `Stop code ${code}`, about: "not known to this page", tone: "bad" };
  }
  const cause = CAUSES[code >>> 8] ?? `cause ${code >>> 8}`;
  return cause === "" ? action : { ...action, about: `${cause}; ${action.about}` };
}
