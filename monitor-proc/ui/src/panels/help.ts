// The help sheet.
import { el, sheet } from "./dom";

type Entries = [string, string][];

const MOUSE: Entries = [
  ["Drag", "turn the view"],
  ["Right drag", "shift the view"],
  ["Wheel", "zoom to the mouse"],
  ["Click", "select an object or an arm"],
  ["Double click", "look closer"],
  [
    "Shift + drag",
    "pull an object by a spring, across the table where the view is from above; it also reaches through arms",
  ],
  ["… and Ctrl", "straight up and down"],
  ["… and wheel", "raise, lower"],
  ["Drag an arrow", "lead the arm (task paused, or reach)"],
  ["… and Shift", "a tenth as far; an arrow is taken before the object behind it"],
];

const TOUCH: Entries = [
  ["One finger", "turn the view"],
  ["Two fingers", "zoom and shift the view"],
  ["Tap", "select an object or an arm"],
  ["Long press, drag", "pull an object by a spring"],
  ["Drag an arrow", "lead the arm (task paused, or reach)"],
];

const KEYS: Entries = [
  ["Space", "play, pause"],
  [".", "step"],
  ["R", "reset the scene"],
  ["G", "open or close the gripper (task paused, or reach)"],
  ["T, E", "arrows at the tool: move, turn the target"],
  ["1 to 5", "view: cell, top, front, side, tool"],
  ["Arrows, Page ↑ ↓", "in the 3D view: move or turn the target by the step of Jog in the Robot tab; Shift: a tenth"],
  ["Enter", "Go, where a target is proposed"],
  ["F", "frame the selection, or the tool"],
  ["Esc", "release; close the guide, a sheet, a drawer"],
  ["← →", "on the timeline: 0.1 s, with Shift 1 s; on tabs: next"],
  ["Page ↑ ↓", "on the timeline: 5 s"],
  ["[ ]", "the mark before, the next mark of the timeline"],
  ["B", "breakpoint at the node that has the focus"],
  ["Ctrl + F", "find in the graph of the task"],
  ["?", "this sheet"],
];

const COMMANDS: Entries = [
  ["robocell pause, resume, step 100, reset", "the clock"],
  ["robocell task start, pause, resume, reset", "the task"],
  ["robocell target 0.5 0 0.3", "lead the tool (task paused)"],
  ["robocell joints A1 A2 …", "each joint of the arm (task paused)"],
  ["robocell gripper open, close", "the gripper"],
  ["robocell drag red_cube --to 0.5 0.2 0.1", "pull an object"],
  ["robocell break LIFT", "pause when the task gets there"],
  ["robocell restart task", "stop a process and start it again"],
  ["robocell load franka-stack --seed 7", "another scene"],
  ["robocell record last 60s", "keep the last minute"],
  ["robocell incident 3", "show a kept failure"],
  ["robocell top", "all of this in the terminal"],
];

const NOTE =
  "Every button says on hover which command does the same. The address keeps the view, overlays, tab, plots and the " +
  "moment of the past: copy it into a bug report. #view=top (front, side, cell) and #t=12.3 may be typed.";

/** The function that opens the sheet. */
export function helpSheet(): () => void {
  const list = (entries: Entries, tag: "kbd" | "code") =>
    el("dl", {}, ...entries.flatMap(([what, about]) => [el("dt", {}, el(tag, {}, what)), el("dd", {}, about)]));
  const touch = [el("h3", {}, "Touch, in the 3D view"), list(TOUCH, "kbd")];
  const dialog = sheet(
    { class: "help", "aria-label": "Help" },
    [el("h2", {}, "Help")],
    el(
      "div",
      { class: "help-columns" },
      el("section", {}, el("h3", {}, "Mouse, in the 3D view"), list(MOUSE, "kbd"), ...touch),
      el("section", {}, el("h3", {}, "Keyboard"), list(KEYS, "kbd")),
      el("section", { class: "wide" }, el("h3", {}, "On the command line"), list(COMMANDS, "code")),
    ),
    el("p", { class: "dim" }, NOTE),
  );
  return () => (dialog.open ? dialog.close() : dialog.showModal());
}
