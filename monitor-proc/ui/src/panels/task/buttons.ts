// Perform Task (or Run again), Pause Task or Resume Task, Reset Task.
import { FLAG } from "../../net/snapshot";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el } from "../dom";

export function taskButtons(context: PanelContext): HTMLElement {
  const why = () => context.cellRefusal();
  const paused = () => context.flag(FLAG.taskPaused);
  const outcome = () => context.store.status?.task.outcome ?? "idle";
  const ended = () => outcome() === "done" || outcome() === "failed";
  const waits = () => context.store.scene?.start_event === true;
  const begun = (): string | null => {
    if (paused()) return "the task is paused: resume it";
    if (ended()) return null;
    if (outcome() === "running") return "the task is running";
    if (waits()) return context.store.status?.task.started === true ? "the start event was given" : null;
    return "this task starts without a start event: press Play";
  };
  const again = async () => {
    const start = waits() ? ([{ do: "task_start" }] as const) : [];
    if (await context.send({ do: "reset" }, { do: "resume" }, ...start)) context.notify("the scene was reset; the task restarts");
  };
  const perform = async () => {
    const ack = await context.store.command({ do: "task_start" });
    if (ack.ok) context.notify(ack.message === "" ? "start event given" : `start event given; ${ack.message}`);
  };
  const start = button(context, {
    label: "Perform Task",
    name: () => (ended() ? "Run again" : "Perform Task"),
    primary: () => !context.paused && !paused() && why() === null && begun() === null,
    about: () => (ended() ? "Reset the scene and run the task again" : "Give the start event: the task waits for it"),
    twin: () => (ended() ? `robocell reset; robocell resume${waits() ? "; robocell task start" : ""}` : "robocell task start"),
    why: () => why() ?? begun(),
    run: () => (ended() ? again() : perform()),
  });
  const pause = button(context, {
    label: "Pause Task",
    name: () => (paused() ? "Resume Task" : "Pause Task"),
    primary: () => !context.paused && paused() && why() === null,
    about: () =>
      paused() ? "Resume the task" : "Pause the task: you lead arm and gripper",
    twin: () => `robocell task ${paused() ? "resume" : "pause"}`,
    why,
    run: () => context.send({ do: paused() ? "task_resume" : "task_pause" }),
  });
  const reset = button(context, {
    label: "Reset Task",
    about: () => "Open the gripper, send the arm to its default pose, put the task back to its beginning; the scene stays as it is",
    twin: () => "robocell task reset",
    why,
    run: async () => {
      const ack = await context.store.command({ do: "task_reset" });
      if (ack.ok) context.notify(`task reset: ${ack.message}`);
    },
  });
  return el("div", { class: "row task-buttons" }, start, pause, reset);
}
