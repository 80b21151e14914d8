// Perform Task, Pause Task or Resume Task, Reset Task.
import { FLAG } from "../../net/snapshot";
import { button } from "../button";
import type { Desk } from "../desk";
import { el, setText } from "../dom";

export function taskButtons(desk: Desk): HTMLElement {
  const why = () => desk.cellRefusal();
  const paused = () => desk.flag(FLAG.taskPaused);
  const perform = button(desk, {
    label: "Perform Task",
    class: "primary",
    about: () =>
      desk.store.scene?.start_event === false
        ? "Give the start event; this task begins without it, too"
        : "Give the start event: the task waits for it",
    twin: () => "robocell task start",
    why,
    run: () => desk.send({ do: "task_start" }),
  });
  const pause = button(desk, {
    label: "Pause Task",
    about: () =>
      paused() ? "Let the task go on from where it is" : "Pause the task: you lead arm and gripper",
    twin: () => `robocell task ${paused() ? "resume" : "pause"}`,
    why,
    run: () => desk.send({ do: paused() ? "task_resume" : "task_pause" }),
  });
  const reset = button(desk, {
    label: "Reset Task",
    about: () => "Put the task back to its beginning; the scene stays as it is",
    twin: () => "robocell task reset",
    why,
    run: () => desk.send({ do: "task_reset" }),
  });
  const name = pause.querySelector("span");
  desk.pulse.add(pause, () => {
    if (name !== null) setText(name, paused() ? "Resume Task" : "Pause Task");
    pause.classList.toggle("warn", paused());
  });
  return el("div", { class: "row task-buttons" }, perform, pause, reset);
}
