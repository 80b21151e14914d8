// Which breakpoints there are, and what can be done where one was reached.
import { button } from "../../button";
import type { Desk } from "../../desk";
import { el, setText } from "../../dom";
import { breakRefusal, breaksOf, breakTwin, reached, toggleBreak } from "./state";

/** The task decides on every tick that this divides. */
const DECISION_TICKS = 10;
/** So many statuses in a row of a cell that is not paused: it was resumed, no step runs. */
const AT_WORK = 2;

function ticksToDecision(desk: Desk): number {
  const tick = desk.snapshot?.tick ?? 0;
  return DECISION_TICKS - (tick % DECISION_TICKS);
}

/** What paused the cell, and the ways on; hidden while no breakpoint was reached. */
export function breakBanner(desk: Desk): HTMLElement {
  const words = el("span", { role: "status" });
  const proceed = button(desk, {
    label: "Continue",
    class: "small",
    about: () => "Resume simulated time, up to the next breakpoint",
    twin: () => "robocell resume",
    why: () => desk.cellRefusal(),
    run: () => desk.send({ do: "resume" }),
  });
  const next = button(desk, {
    label: "Next decision",
    class: "small",
    about: () => "Run up to the next decision of the task, then pause",
    twin: () => `robocell step ${ticksToDecision(desk)}`,
    why: () => desk.cellRefusal(),
    run: () => desk.send({ do: "step", count: ticksToDecision(desk) }),
  });
  const root = el("div", { class: "break-banner row" }, words, proceed, next);
  // A step from a breakpoint on is still the debugging of it, also while it runs.
  let running = AT_WORK;
  const show = () => {
    const name = reached(desk.store);
    running = name !== null ? 0 : desk.paused ? running : running + 1;
    root.hidden = running >= AT_WORK;
    setText(words, root.hidden ? "" : name === null ? "The step is done" : `At breakpoint ${name}`);
  };
  desk.store.on("status", show);
  show();
  return root;
}

/** All breakpoints with buttons that remove them; hidden while there are none. */
export function breakList(desk: Desk): HTMLElement {
  const list = el("ul", { class: "break-list", "aria-label": "Breakpoints" });
  const root = el("div", { class: "breaks row" }, el("span", { class: "dim" }, "Breakpoints"), list);
  let shown = "";
  let rows = new Map<string, HTMLElement>();
  const show = () => {
    const breaks = [...(breaksOf(desk.store) ?? [])];
    root.hidden = breaks.length === 0;
    const now = JSON.stringify(breaks);
    if (now === shown) return;
    shown = now;
    if (rows.size !== breaks.length || breaks.some(([name]) => !rows.has(name))) {
      rows = new Map(breaks.map(([name]) => [name, rows.get(name) ?? listed(desk, name)]));
      list.replaceChildren(...rows.values());
    }
    for (const [name, hits] of breaks) {
      const count = rows.get(name)?.querySelector(".hits");
      if (count != null) setText(count, hits === 0 ? "" : `× ${hits}`);
    }
  };
  desk.store.on("status", show);
  show();
  return root;
}

function listed(desk: Desk, name: string): HTMLElement {
  const remove = button(desk, {
    icon: "close",
    class: "icon-only quiet",
    about: () => `Remove the breakpoint at ${name}`,
    twin: () => breakTwin(desk, name),
    why: () => breakRefusal(desk),
    run: () => toggleBreak(desk, name),
  });
  return el("li", {}, el("i", { class: "break-mark" }), el("code", {}, name), el("span", { class: "hits dim num", title: "How often it was reached" }), remove);
}
