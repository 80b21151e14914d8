// What buttons and keys do alike, each with its twin on the command line.
import { FLAG } from "../net/snapshot";
import type { Desk } from "./desk";
import type { ButtonSpec } from "./button";

/** The commands of a whole cell, as buttons and keys know them. */
export interface Actions {
  playPause: ButtonSpec;
  stop: ButtonSpec;
  step: ButtonSpec;
  reset: ButtonSpec;
  gripper: ButtonSpec;
}

export function actions(desk: Desk, steps: () => number): Actions {
  // A recording has a clock of its own, and no cell.
  const clock = () => (desk.store.hello?.live === false ? desk.refusal() : desk.cellRefusal());
  const cell = () => desk.cellRefusal();
  return {
    playPause: {
      icon: "play",
      class: "play",
      about: () => (desk.paused ? "Play: simulated time continues" : "Pause simulated time"),
      twin: () => (desk.paused ? "robocell resume" : "robocell pause"),
      why: clock,
      run: () => desk.send({ do: desk.paused ? "resume" : "pause" }),
    },
    stop: {
      icon: "stop",
      about: () => "Stop: pause, and put the scene back to its beginning",
      twin: () => "robocell pause; robocell reset",
      why: cell,
      run: () => desk.send({ do: "pause" }, { do: "reset" }),
    },
    step: {
      icon: "step",
      about: () => `Step: run ${steps()} ms of simulated time, then pause`,
      twin: () => `robocell step ${steps()}`,
      why: clock,
      run: () => desk.send({ do: "step", count: steps() }),
    },
    reset: {
      icon: "reset",
      about: () => "Reset: put the scene back to its beginning",
      twin: () => "robocell reset",
      why: cell,
      run: () => desk.send({ do: "reset" }),
    },
    gripper: gripper(desk, cell),
  };
}

const OPEN_SHARE = 0.9;

/** Whether the gripper of the selected arm has something to let go, or is shut. */
export function gripperIsClosed(desk: Desk): boolean {
  const state = desk.snapshot?.arms[desk.arm];
  const gripper = desk.store.scene?.arms[desk.arm]?.gripper;
  if (!state || !gripper) return false;
  if (state.attached || state.held !== null) return true;
  // Suction that found nothing stays on until it is switched off.
  if (gripper.kind === "suction") return desk.store.status?.equipment?.suction[desk.arm]?.on === true;
  return gripper.max_width_m > 0 && state.width < OPEN_SHARE * gripper.max_width_m;
}

function gripper(desk: Desk, cell: () => string | null): ButtonSpec {
  const to = () => (gripperIsClosed(desk) ? "open" : "close");
  const which = () => (desk.arm === 0 ? "" : ` --arm ${desk.arm}`);
  return {
    about: () => `${to() === "open" ? "Open" : "Close"} the gripper of ${desk.armName(desk.arm)}`,
    twin: () => `robocell gripper ${to()}${which()}`,
    why: () => cell() ?? handRefusal(desk),
    run: () => desk.send({ do: "gripper", arm: desk.arm, to: to() }),
  };
}

/** Why arm and gripper cannot be led by hand now, or null. */
export function handRefusal(desk: Desk): string | null {
  const { snapshot, store } = desk;
  if (!snapshot) return "no state yet";
  const led = store.hello?.run.policy === "follow" || desk.flag(FLAG.taskPaused);
  return led ? null : "the task leads the arm: pause the task first";
}
