// What an operator does to the task: buttons of the task panel and of the status bar.
import type { ButtonSpec } from "../button";
import type { PanelContext } from "../context";

export type TaskAction = "again" | "start" | "pause" | "resume" | "reset";

export function taskActions(context: PanelContext): Record<TaskAction, ButtonSpec> {
  const why = () => context.cellRefusal();
  // While the clock is paused, Play comes first, unless the task has ended.
  const primary = () => !context.paused && why() === null;
  const waits = () => context.store.scene?.start_event === true;
  return {
    again: {
      label: "Run again",
      about: () => "Reset the scene and run the task again",
      twin: () => `robocell reset; robocell resume${waits() ? "; robocell task start" : ""}`,
      why,
      // A task that works again after it was done is not to be ended first of all.
      primary: () => why() === null && context.isTaskOver,
      run: () => again(context, waits()),
    },
    start: {
      label: "Perform Task",
      about: () => "Give the start event: the task waits for it",
      twin: () => "robocell task start",
      why,
      primary,
      run: () => perform(context),
    },
    pause: {
      label: "Pause Task",
      // An arm is led while the task is paused, also of a task that has ended.
      about: () => `Pause the task${context.isTaskOver ? ", which has ended" : ""}: you lead arm and gripper`,
      twin: () => "robocell task pause",
      why,
      run: () => context.send({ do: "task_pause" }),
    },
    resume: {
      label: "Resume Task",
      about: () => "Resume the task",
      twin: () => "robocell task resume",
      why,
      primary,
      run: () => context.send({ do: "task_resume" }),
    },
    reset: {
      label: "Reset Task",
      about: () =>
        "Open the gripper, send the arm to its default pose, put the task back to its beginning; the scene stays as it is",
      twin: () => "robocell task reset",
      why,
      run: async () => {
        const ack = await context.store.command({ do: "task_reset" });
        if (ack.ok) context.notify(`task reset: ${ack.message}`);
      },
    },
  };
}

async function again(context: PanelContext, startEvent: boolean): Promise<void> {
  const start = startEvent ? ([{ do: "task_start" }] as const) : [];
  if (await context.send({ do: "reset" }, { do: "resume" }, ...start))
    context.notify("the scene was reset; the task restarts");
}

async function perform(context: PanelContext): Promise<void> {
  const ack = await context.store.command({ do: "task_start" });
  if (ack.ok) context.notify(ack.message === "" ? "start event given" : `start event given; ${ack.message}`);
}

/** A button that is one of two actions: `second` where `isSecond`, else `first`. */
export function eitherAction(first: ButtonSpec, second: ButtonSpec, isSecond: () => boolean): ButtonSpec {
  const now = () => (isSecond() ? second : first);
  return {
    label: first.label ?? "",
    name: () => now().label ?? "",
    about: () => now().about(),
    twin: () => now().twin(),
    why: () => now().why?.() ?? null,
    run: () => now().run(),
  };
}
