// What the view shows over the cell, from where, and what the gizmo does.
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setText } from "../dom";
import { words } from "../format";
import type { ViewApi } from "../view-api";

const CAMERAS = ["cell", "top", "front", "side", "tool"];

/** What each overlay shows. */
const ABOUT: Record<string, string> = {
  targets: "Frames of target and tool, and the way between them",
  approach: "Funnel along which the tool approaches its target",
  spheres: "Spheres of collision avoidance, and the obstacles they avoid",
  distances: "Line from each arm's nearest sphere to each obstacle, with its length",
  contacts: "Rims around objects that a robot or an operator touches",
  suction: "Load of the suction cup (% of its limit)",
  trails: "Way of each tool in the last 10 s",
  ghost: "Setpoint of the controller as a transparent robot",
  names: "Names of objects and arms",
};

export function viewTools(context: PanelContext): HTMLElement {
  const { view } = context;
  if (view === null) return el("p", { class: "dim" }, "This browser has no 3D view.");
  const boxes = view.toggles.names().map((name) => {
    const box = el("input", { type: "checkbox" });
    box.checked = view.toggles.get(name);
    box.addEventListener("change", () => view.toggles.set(name, box.checked));
    context.pulse.add(box, () => {
      box.checked = view.toggles.get(name);
    });
    return el("label", { class: "check", title: ABOUT[name] ?? words(name) }, box, words(name));
  });
  const cameras = CAMERAS.map((name, index) =>
    button(context, {
      label: name,
      class: "small",
      about: () => `Look from: ${name} (key ${index + 1}${name === "tool" ? "" : `; #view=${name} in the address`})`,
      twin: () => null,
      run: () => view.camera(index + 1),
    }),
  );
  const frame = button(context, {
    label: "frame selection",
    class: "small",
    about: () => "Frame the selection, or the tool where nothing is selected (key F)",
    twin: () => null,
    run: () => view.frameSelection(),
  });
  return el(
    "div",
    { class: "view-tools" },
    el("div", { class: "checks" }, ...boxes),
    el("div", { class: "segments", role: "group", "aria-label": "Camera" }, ...cameras),
    frame,
    gizmo(context),
    quality(context, view),
  );
}

/** What the picture does without to stay fluent. */
function quality(context: PanelContext, view: ViewApi): HTMLElement {
  const title =
    "While something moves, the picture gives up quality step by step to stay fluent. At rest it is drawn in full";
  const line = el("p", { class: "dim quality", title });
  context.pulse.add(line, () => setText(line, `Picture: ${view.picture}`));
  return line;
}

function gizmo(context: PanelContext): HTMLElement {
  const make = (mode: "translate" | "rotate", name: string, key: string) =>
    button(context, {
      label: `${name} target`,
      class: "small",
      about: () => `The gizmo will ${name} the target (key ${key}); it leads the arm while the task is paused`,
      twin: () => "robocell target X Y Z R P YAW",
      why: () => context.cellRefusal(),
      run: () => context.view?.gizmoMode(mode),
    });
  const buttons = [make("translate", "move", "T"), make("rotate", "turn", "E")];
  return el("div", { class: "segments", role: "group", "aria-label": "Gizmo" }, ...buttons);
}
