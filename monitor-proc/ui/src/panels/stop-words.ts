// The codes of StopAction (ipc-types/src/arm.rs), in words.

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

export function stopWords(code: number): StopWords {
  return ACTIONS[code] ?? { name: `Stop code ${code}`, about: "not known to this page", tone: "bad" };
}
