// The help sheet.
import { el } from "./dom";

const KEYS: [string, string][] = [
  ["Space", "play, pause"],
  [".", "step"],
  ["R", "reset the scene"],
  ["G", "open or close the gripper"],
  ["T, E", "gizmo: move, turn the target"],
  ["1 to 5", "camera: scene, top, front, …"],
  ["Shift + drag", "pull a body by a spring"],
  ["Esc", "let go, close"],
  ["B", "breakpoint at the node that has the focus"],
  ["Ctrl + F", "find in the graph of the task"],
  ["← →", "timeline: 0.1 s; Shift: 1 s"],
  ["?", "this sheet"],
];

const COMMANDS: [string, string][] = [
  ["robocell pause, resume, step 100, reset", "the clock"],
  ["robocell task start, pause, resume, reset", "the task"],
  ["robocell target 0.5 0 0.3", "lead the tool (task paused)"],
  ["robocell gripper open, close", "the gripper"],
  ["robocell drag red_cube --to 0.5 0.2 0.1", "pull an object"],
  ["robocell break LIFT", "pause where the task gets there"],
  ["robocell restart task --policy bt", "begin a process anew"],
  ["robocell load franka-stack --seed 7", "another scene"],
  ["robocell record last 60s", "keep what just happened"],
  ["robocell incident 3", "what was kept of a failure"],
  ["robocell top", "all of this in the terminal"],
];

/** The function that opens the sheet. */
export function helpSheet(): () => void {
  const list = (entries: [string, string][], tag: "kbd" | "code") =>
    el("dl", {}, ...entries.flatMap(([what, about]) => [el("dt", {}, el(tag, {}, what)), el("dd", {}, about)]));
  const close = el("button", { type: "button", class: "button" }, "Close");
  const dialog = el(
    "dialog",
    { class: "help", "aria-label": "Help" },
    el("header", {}, el("h2", {}, "Help"), close),
    el("div", { class: "help-columns" },
      el("section", {}, el("h3", {}, "Keys and mouse"), list(KEYS, "kbd")),
      el("section", {}, el("h3", {}, "The same on the command line"), list(COMMANDS, "code")),
    ),
    el("p", { class: "dim" }, "Every button says on hover which command does the same. The address keeps camera, tab and plots: copy it into a bug report."),
  );
  close.addEventListener("click", () => dialog.close());
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });
  document.body.append(dialog);
  return () => (dialog.open ? dialog.close() : dialog.showModal());
}
