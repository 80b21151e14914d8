// Which breakpoints there are, and what can be done where one was reached.
import { button } from "../../button";
import type { PanelContext } from "../../context";
import { el, setText } from "../../dom";
import { breakRefusal, breaksOf, breakTwin, reached, toggleBreak } from "./state";

/** The task decides on every tick that this divides. */
const DECISION_TICKS = 10;
/** So many statuses in a row of a cell that is not paused: it was resumed, no step runs. */
const AT_WORK = 2;

function ticksToDecision(context: PanelContext): number {
  const tick = context.snapshot?.tick ?? 0;
  return DECISION_TICKS - (tick % DECISION_TICKS);
}

/** What paused the cell, and the ways on; hidden while no breakpoint was reached. */
export function breakBanner(context: PanelContext): HTMLElement {
  const words = el("span", { role: "status" });
  const proceed = button(context, {
    label: "Continue",
    class: "small",
    about: () => "Resume simulated time, up to the next breakpoint",
    twin: () => "robocell resume",
    why: () => context.cellRefusal(),
    run: () => context.send({ do: "resume" }),
  });
  const next = button(context, {
    label: "Next decision",
    class: "small",
    about: () => "Run up to the next decision of the task, then pause",
    twin: () => `robocell step ${ticksToDecision(context)}`,
    why: () => context.cellRefusal(),
    run: () => context.send({ do: "step", count: ticksToDecision(context) }),
  });
  const root = el("div", { class: "break-banner row" }, words, proceed, next);
  // A step from a breakpoint on is still the debugging of it, also while it runs.
  let running = AT_WORK;
  const show = () => {
    const name = reached(context.store);
    running = name !== null ? 0 : context.paused ? running : running + 1;
    root.hidden = running >= AT_WORK;
    setText(words, root.hidden ? "" : name === null ? "The step is done" : `At breakpoint ${name}`);
  };
  context.store.on("status", show);
  show();
  return root;
}

/** All breakpoints with buttons that remove them; hidden while there are none. */
export function breakList(context: PanelContext): HTMLElement {
  const list = el("ul", { class: "break-list", "aria-label": "Breakpoints" });
  const root = el("div", { class: "breaks row" }, el("span", { class: "dim" }, "Breakpoints"), list);
  let shown = "";
  let rows = new Map<string, HTMLElement>();
  const show = () => {
    const breaks = [...(breaksOf(context.store) ?? [])];
    root.hidden = breaks.length === 0;
    const now = JSON.stringify(breaks);
    if (now === shown) return;
    shown = now;
    if (rows.size !== breaks.length || breaks.some(([name]) => !rows.has(name))) {
      rows = new Map(breaks.map(([name]) => [name, rows.get(name) ?? listed(context, name)]));
      list.replaceChildren(...rows.values());
    }
    for (const [name, hits] of breaks) {
      const count = rows.get(name)?.querySelector(".hits");
      if (count != null) setText(count, hits === 0 ? "" : `× ${hits}`);
    }
  };
  context.store.on("status", show);
  show();
  return root;
}

function listed(context: PanelContext, name: string): HTMLElement {
  const remove = button(context, {
    icon: "close",
    class: "icon-only quiet",
    about: () => `Remove the breakpoint at ${name}`,
    twin: () => breakTwin(context, name),
    why: () => breakRefusal(context),
    run: () => toggleBreak(context, name),
  });
  const hits = el("span", { class: "hits dim num", title: "How often it was reached" });
  return el("li", {}, el("i", { class: "break-mark" }), el("code", {}, name), hits, remove);
}
