// The place beside a node, state or guard that sets and removes its breakpoint.
import type { PanelContext } from "../../context";
import { el, setAttr, svg } from "../../dom";
import { breaksOf, breakTwin, reached, toggleBreak } from "./state";

const WATCHED = "data-break";
const watching = new WeakSet<PanelContext>();

/** A dot in the gutter of a line. It is a tab stop unless its line has a key for it. */
export function breakDot(context: PanelContext, name: string, tabIndex: 0 | -1): HTMLElement {
  const node = el("button", { type: "button", class: "break-dot", tabindex: tabIndex, [WATCHED]: name });
  listen(context, name, node);
  return node;
}

/** The same in a drawing, at a point of it. */
export function breakSpot(context: PanelContext, name: string, x: number, y: number): SVGElement {
  const [target, dot] = [9, 4].map((r) => svg("circle", { cx: x, cy: y, r }));
  const node = svg("g", { class: "break-spot", [WATCHED]: name }, svg("title", {}), target ?? null, dot ?? null);
  listen(context, name, node);
  return node;
}

function listen(context: PanelContext, name: string, node: Element): void {
  node.addEventListener("click", (event) => {
    event.stopPropagation();
    toggleBreak(context, name);
  });
  watch(context);
  mark(context, node);
}

/** Keeps all dots of the page as the status says. */
function watch(context: PanelContext): void {
  if (watching.has(context)) return;
  watching.add(context);
  let shown = "";
  context.store.on("status", ({ breaks, pause_cause, pause_detail }) => {
    const names = breaks.map(({ name }) => name);
    const now = JSON.stringify([names, pause_cause, pause_detail, context.cellRefusal() === null]);
    if (now === shown) return;
    shown = now;
    for (const node of document.querySelectorAll(`[${WATCHED}]`)) mark(context, node);
  });
}

function mark(context: PanelContext, node: Element): void {
  const name = node.getAttribute(WATCHED) ?? "";
  const breaks = breaksOf(context.store);
  const on = breaks?.has(name) === true;
  node.classList.toggle("none", breaks === null);
  node.classList.toggle("set", on);
  node.parentElement?.classList.toggle("reached", reached(context.store) === name);
  const about = `${on ? "Remove the breakpoint" : "Pause the cell"} at ${name}`;
  const words = `${about}\n$ ${context.onCell(breakTwin(context, name))}`;
  if (node instanceof HTMLElement) {
    node.title = words;
    setAttr(node, "aria-label", `Breakpoint at ${name}`);
    setAttr(node, "aria-pressed", String(on));
  } else {
    const title = node.querySelector("title");
    if (title !== null) title.textContent = words;
  }
}
