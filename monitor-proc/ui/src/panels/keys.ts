// The keyboard: one key for each frequent action.
import type { Actions } from "./actions";
import type { ButtonSpec } from "./button";
import type { PanelContext } from "./context";

/** Whether a key belongs to what has the focus. */
function isTyping(event: KeyboardEvent): boolean {
  const target = event.target instanceof Element ? event.target : null;
  if (target?.closest("input, select, textarea, dialog") != null) return true;
  // Space presses the button that has the focus.
  return event.key === " " && target?.closest("button, summary, [role=button]") != null;
}

export function mountKeys(context: PanelContext, act: Actions, help: () => void): void {
  const press = (spec: ButtonSpec) => {
    const reason = spec.why?.() ?? null;
    if (reason === null) spec.run();
    else context.notify(`not now: ${reason}`);
  };
  const keys: Record<string, () => void> = {
    " ": () => press(act.playPause),
    ".": () => press(act.step),
    r: () => press(act.reset),
    g: () => press(act.gripper),
    t: () => context.view?.gizmoMode("translate"),
    e: () => context.view?.gizmoMode("rotate"),
    f: () => context.view?.frameSelection(),
    "[": () => context.toMark(-1),
    "]": () => context.toMark(1),
    "?": help,
  };
  for (let camera = 1; camera <= 5; camera++) keys[String(camera)] = () => context.view?.camera(camera);
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat || isTyping(event)) return;
    const run = keys[event.key.toLowerCase()];
    if (run === undefined) return;
    event.preventDefault();
    run();
  });
}
