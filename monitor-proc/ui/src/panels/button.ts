// Buttons that say why they do nothing, and what would do the same on the
// command line.
import type { PanelContext } from "./context";
import { el, setAttr, setText, setTitle } from "./dom";
import { type IconName, icon } from "./icons";

export interface ButtonSpec {
  label?: string;
  icon?: IconName;
  class?: string;
  /** Its label as things are now. */
  name?: () => string;
  /** Whether it is what can be done next. */
  primary?: () => boolean;
  /** Its effect, in words. */
  about: () => string;
  /** The same on the command line, or null where there is nothing like it. */
  twin: () => string | null;
  /** Why it cannot be pressed now, or null. */
  why?: () => string | null;
  run: () => unknown;
}

/** By button: shows it as things are now. */
const refreshes = new WeakMap<HTMLButtonElement, () => void>();

/** Shows or hides a button, which is not followed while it is hidden. */
export function showButton(node: HTMLButtonElement, isShown: boolean): void {
  if (node.hidden !== isShown) return;
  node.hidden = !isShown;
  if (isShown) refreshes.get(node)?.();
}

/** A button of `spec`. It stays reachable when it is off, so that its reason is. */
export function button(context: PanelContext, spec: ButtonSpec): HTMLButtonElement {
  const { label, class: kind = "" } = spec;
  const node = el("button", { type: "button", class: `button ${kind}` });
  if (spec.icon !== undefined) node.append(icon(spec.icon));
  const name = label === undefined ? null : el("span", {}, label);
  if (name !== null) node.append(name);
  const why = () => spec.why?.() ?? null;
  let before = "";
  const refresh = () => {
    const [reason, about, twin] = [why(), spec.about(), spec.twin()];
    const [text, primary] = [spec.name?.(), spec.primary?.()];
    const lines = [about, twin === null ? "" : `$ ${context.onCell(twin)}`];
    if (reason !== null) lines.push(`Not now: ${reason}`);
    const title = lines.filter((line) => line !== "").join("\n");
    // A hundred buttons ten times a second: to ask the page what they show takes longer.
    const now = `${reason} ${text} ${primary} ${title}`;
    if (now === before) return;
    before = now;
    setAttr(node, "aria-disabled", reason === null ? null : "true");
    if (text !== undefined && name !== null) setText(name, text);
    if (primary !== undefined) node.classList.toggle("primary", primary);
    setTitle(node, title);
    if (label === undefined) setAttr(node, "aria-label", about);
  };
  node.addEventListener("click", (event) => {
    // After a mouse's click, Space is play and pause again.
    if (event.detail > 0) node.blur();
    const reason = why();
    if (reason === null) spec.run();
    else context.notify(`not now: ${reason}`);
    refresh();
  });
  refreshes.set(node, refresh);
  context.pulse.add(node, refresh);
  refresh();
  return node;
}

/** Shows another icon on a button made with one. */
export function setIcon(node: HTMLButtonElement, name: IconName): void {
  const before = node.querySelector("svg");
  if (before?.dataset.icon !== name) before?.replaceWith(icon(name));
}
