// What buttons and keys do alike, each with its twin on the command line.
import type { ButtonSpec } from "./button";
import type { PanelContext } from "./context";

/** The commands of a whole cell, as buttons and keys know them. */
export interface Actions {
  playPause: ButtonSpec;
  stop: ButtonSpec;
  step: ButtonSpec;
  reset: ButtonSpec;
  gripper: ButtonSpec;
}

export function actions(context: PanelContext, steps: () => number): Actions {
  // A recording has a clock of its own, and no cell.
  const clock = () => (context.store.hello?.live === false ? context.refusal() : context.cellRefusal());
  const cell = () => context.cellRefusal();
  return {
    playPause: {
      icon: "play",
      class: "play",
      about: () => (context.paused ? "Play: simulated time continues" : "Pause simulated time"),
      twin: () => (context.paused ? "robocell resume" : "robocell pause"),
      why: clock,
      run: () => context.send({ do: context.paused ? "resume" : "pause" }),
    },
    stop: {
      icon: "stop",
      about: () => "Stop: pause, and put the scene back to its beginning",
      twin: () => "robocell pause; robocell reset",
      why: cell,
      run: () => context.send({ do: "pause" }, { do: "reset" }),
    },
    step: {
      icon: "step",
      about: () => `Step: run ${steps()} ms of simulated time, then pause`,
      twin: () => `robocell step ${steps()}`,
      why: clock,
      run: () => context.send({ do: "step", count: steps() }),
    },
    reset: {
      icon: "reset",
      about: () => "Reset: put the scene back to its beginning",
      twin: () => "robocell reset",
      why: cell,
      run: () => context.send({ do: "reset" }),
    },
    gripper: gripper(context, cell),
  };
}

const OPEN_SHARE = 0.9;

/** Whether the gripper of the selected arm has something to let go, or is shut. */
export function gripperIsClosed(context: PanelContext): boolean {
  const state = context.snapshot?.arms[context.arm];
  const gripper = context.store.scene?.arms[context.arm]?.gripper;
  if (!state || !gripper) return false;
  if (state.attached || state.held !== null) return true;
  // Suction that found nothing stays on until it is switched off.
  if (gripper.kind === "suction") return context.store.status?.equipment?.suction[context.arm]?.on === true;
  return gripper.max_width_m > 0 && state.width < OPEN_SHARE * gripper.max_width_m;
}

function gripper(context: PanelContext, cell: () => string | null): ButtonSpec {
  const to = () => (gripperIsClosed(context) ? "open" : "close");
  const which = () => (context.arm === 0 ? "" : ` --arm ${context.arm}`);
  return {
    about: () => `${to() === "open" ? "Open" : "Close"} the gripper of ${context.armName(context.arm)}`,
    twin: () => `robocell gripper ${to()}${which()}`,
    why: () => cell() ?? handRefusal(context),
    run: () => context.send({ do: "gripper", arm: context.arm, to: to() }),
  };
}

/** Why arm and gripper cannot be led by hand now, or null. */
export function handRefusal(context: PanelContext): string | null {
  return context.hand.refusal();
}
