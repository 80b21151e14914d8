// What the view shows over the cell, from where, and what the gizmo does.
import { button } from "../button";
import type { Desk } from "../desk";
import { el, setText } from "../dom";
import { words } from "../format";
import type { ViewApi } from "../view-api";

const CAMERAS = ["scene", "top", "front", "side", "tool"];

export function viewTools(desk: Desk): HTMLElement {
  const { view } = desk;
  if (view === null) return el("p", { class: "dim" }, "There is no 3D view in this browser.");
  const boxes = view.toggles.names().map((name) => {
    const box = el("input", { type: "checkbox" });
    box.checked = view.toggles.get(name);
    box.addEventListener("change", () => view.toggles.set(name, box.checked));
    desk.pulse.add(box, () => {
      box.checked = view.toggles.get(name);
    });
    return el("label", { class: "check" }, box, words(name));
  });
  const cameras = CAMERAS.map((name, index) =>
    button(desk, {
      label: name,
      class: "small",
      about: () => `Look from: ${name} (key ${index + 1})`,
      twin: () => null,
      run: () => view.camera(index + 1),
    }),
  );
  return el(
    "div",
    { class: "view-tools" },
    el("div", { class: "checks" }, ...boxes),
    el("div", { class: "segments", role: "group", "aria-label": "Camera" }, ...cameras),
    gizmo(desk),
    quality(desk, view),
  );
}

/** What the picture does without to stay fluent. */
function quality(desk: Desk, view: ViewApi): HTMLElement {
  const line = el("p", { class: "dim quality", title: "The picture gives up quality step by step where it would not be fluent" });
  desk.pulse.add(line, () => setText(line, `Picture: ${view.quality.level.name}`));
  return line;
}

function gizmo(desk: Desk): HTMLElement {
  const modes = [
    ["translate", "move", "T"],
    ["rotate", "turn", "E"],
  ] as const;
  const buttons = modes.map(([mode, name, key]) =>
    button(desk, {
      label: `${name} target`,
      class: "small",
      about: () => `The gizmo will ${name} the target (key ${key}); it leads the arm while the task is paused`,
      twin: () => "robocell target X Y Z R P YAW",
      run: () => desk.view?.gizmoMode(mode),
    }),
  );
  return el("div", { class: "segments", role: "group", "aria-label": "Gizmo" }, ...buttons);
}
