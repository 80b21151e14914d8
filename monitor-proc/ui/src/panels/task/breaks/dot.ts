// The place beside a node, state or guard that sets and removes its breakpoint.
import type { Desk } from "../../desk";
import { el, setAttr, svg } from "../../dom";
import { breaksOf, breakTwin, reached, toggleBreak } from "./state";

const WATCHED = "data-break";
const watching = new WeakSet<Desk>();

/** A dot in the gutter of a line. It is a tab stop unless its line has a key for it. */
export function breakDot(desk: Desk, name: string, tabIndex: 0 | -1): HTMLElement {
  const node = el("button", { type: "button", class: "break-dot", tabindex: tabIndex, [WATCHED]: name });
  node.addEventListener("click", (event) => {
    event.stopPropagation();
    toggleBreak(desk, name);
  });
  watch(desk);
  mark(desk, node);
  return node;
}

/** The same in a drawing, at a point of it. */
export function breakSpot(desk: Desk, name: string, x: number, y: number): SVGElement {
  const [target, dot] = [9, 4].map((r) => svg("circle", { cx: x, cy: y, r }));
  const node = svg("g", { class: "break-spot", [WATCHED]: name }, svg("title", {}), target ?? null, dot ?? null);
  node.addEventListener("click", (event) => {
    event.stopPropagation();
    toggleBreak(desk, name);
  });
  watch(desk);
  mark(desk, node);
  return node;
}

/** Keeps all dots of the page as the status says. */
function watch(desk: Desk): void {
  if (watching.has(desk)) return;
  watching.add(desk);
  let shown = "";
  desk.store.on("status", ({ breaks, pause_cause, pause_detail }) => {
    const names = breaks.map(({ name }) => name);
    const now = JSON.stringify([names, pause_cause, pause_detail, desk.cellRefusal() === null]);
    if (now === shown) return;
    shown = now;
    for (const node of document.querySelectorAll(`[${WATCHED}]`)) mark(desk, node);
  });
}

function mark(desk: Desk, node: Element): void {
  const name = node.getAttribute(WATCHED) ?? "";
  const breaks = breaksOf(desk.store);
  const on = breaks?.has(name) === true;
  node.classList.toggle("none", breaks === null);
  node.classList.toggle("set", on);
  node.parentElement?.classList.toggle("reached", reached(desk.store) === name);
  const about = `${on ? "Remove the breakpoint" : "Pause the cell"} at ${name}`;
  const words = `${about}\n$ ${desk.onCell(breakTwin(desk, name))}`;
  if (node instanceof HTMLElement) {
    node.title = words;
    setAttr(node, "aria-label", `Breakpoint at ${name}`);
    setAttr(node, "aria-pressed", String(on));
  } else {
    const title = node.querySelector("title");
    if (title !== null) title.textContent = words;
  }
}
