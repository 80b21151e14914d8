// Perform Task (or Run again), Pause Task or Resume Task, Reset Task.
import { FLAG } from "../../net/snapshot";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el } from "../dom";
import { eitherAction, taskActions } from "./actions";

export function taskButtons(context: PanelContext): HTMLElement {
  const { again, start, pause, resume, reset } = taskActions(context);
  const paused = () => context.flag(FLAG.taskPaused);
  const outcome = () => context.store.status?.task.outcome ?? "idle";
  const ended = () => outcome() === "done" || outcome() === "failed";
  const waits = () => context.store.scene?.start_event === true;
  const begun = (): string | null => {
    if (paused()) return "the task is paused: resume it";
    if (ended()) return null;
    // A task may call itself running while it waits for the start event.
    if (waits() && context.store.status?.task.started !== true) return null;
    if (outcome() === "running") return "the task is running";
    return waits() ? "the start event was given" : "this task starts without a start event: press Play";
  };
  const first = eitherAction(start, again, ended);
  const second = eitherAction(pause, resume, paused);
  const why = () => first.why?.() ?? begun();
  const primary = () => (ended() ? context.isTaskOver : !context.paused) && !paused() && why() === null;
  return el(
    "div",
    { class: "row task-buttons" },
    button(context, { ...first, why, primary }),
    button(context, { ...second, primary: () => !context.paused && paused() && context.cellRefusal() === null }),
    button(context, reset),
  );
}
