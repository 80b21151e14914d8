// The card of the first minute, over the 3D view: what a demo shows and what to try.
// A card that was closed stays closed in this browser, for this demo. The cell is framed
// beside the card, or below it where the card is one line.
import type { Scene } from "../../net/protocol";
import { isPicture } from "../../settled";
import { recall, remember } from "../browser-memory";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr } from "../dom";
import { icon } from "../icons";
import { copyable } from "./copy";
import { guideOf, REPLAY } from "./texts";

const CLOSED = "closed";
const keyOf = (scene: Scene) => `robocell-guide-${scene.demo}`;

export function mountGuide(context: PanelContext): void {
  if (isPicture()) return;
  const attrs = { class: "button small guide-opener", title: "About this demo, and things to try" };
  const opener = plainButton(attrs, () => choose(true), "Guide");
  const card = el("aside", { class: "guide-card scroll", "aria-label": "Guide", tabindex: -1 });
  const place = el("div", { id: "guide" }, opener, card);
  const show = (open: boolean) => {
    card.hidden = !open;
    opener.hidden = open;
    coverView(context, place, card);
  };
  new ResizeObserver(() => coverView(context, place, card)).observe(place);
  const choose = (open: boolean) => {
    const { scene } = context.store;
    if (scene === null) return;
    remember(keyOf(scene), open ? null : CLOSED);
    show(open);
    if (!place.contains(document.activeElement) && document.activeElement !== document.body) return;
    // Not to the button that opens it: Space would press that, and pause nothing.
    if (open) card.focus({ preventScroll: true });
    else document.querySelector<HTMLElement>("#view canvas")?.focus({ preventScroll: true });
  };
  const press = (event: KeyboardEvent) => {
    if (event.key === "Escape" && !card.hidden && !isTaken(context, event)) choose(false);
  };
  addEventListener("keydown", press, { capture: true });
  let shown: string | null = null;
  const take = (scene: Scene) => {
    const { hello } = context.store;
    const text = JSON.stringify([scene.demo, scene.description, hello?.run.cell, hello?.live]);
    if (text === shown) return;
    shown = text;
    card.replaceChildren(...content(context, scene, () => choose(false)));
    card.scrollTop = 0;
    place.hidden = false;
    show(recall(keyOf(scene)) !== CLOSED);
  };
  place.hidden = true;
  document.body.append(place);
  context.store.on("scene", take);
  if (context.store.scene !== null) take(context.store.scene);
}

/** Tells the view which border of it the card covers. A line that was opened covers what a person let it cover. */
function coverView(context: PanelContext, place: HTMLElement, card: HTMLElement): void {
  const { width, bottom, right } = card.getBoundingClientRect();
  const { left, top, width: room } = place.getBoundingClientRect();
  const isLine = width > room / 2;
  if (card.classList.contains("open") && isLine) return;
  const covers = (isThere: boolean, length: number) => (isThere && !card.hidden ? length : 0);
  context.view?.cover({ left: covers(!isLine, right - left), top: covers(isLine, bottom - top) });
}

/** Whether Escape closes or lets go of something else first. */
function isTaken(context: PanelContext, event: KeyboardEvent): boolean {
  const target = event.target instanceof Element ? event.target : null;
  if (target?.closest("dialog, .popover, .scene-form, input, select, textarea, .scene-tree") != null) return true;
  if (document.querySelector("dialog[open], body.show-left, body.show-right") !== null) return true;
  return context.view?.busy === true;
}

function content(context: PanelContext, scene: Scene, dismiss: () => void): Node[] {
  const { title, see, tries } = context.store.hello?.live === false ? REPLAY : guideOf(scene);
  const named = { class: "button icon-only quiet", "aria-label": "Close the guide", title: "Close (Esc)" };
  const close = plainButton(named, dismiss, icon("close"));
  const toggle = () => setAttr(more, "aria-expanded", `${more.closest(".guide-card")?.classList.toggle("open")}`);
  const attrs = { class: "button small try", "aria-expanded": "false", title: "Show what to try" };
  const more = plainButton(attrs, toggle, "Try");
  const items = tries.map(({ what, command }) => el("li", {}, what, copyable(context, command)));
  return [
    el("header", {}, el("h2", {}, title), el("span", { class: "line dim", title: see }, see), more, close),
    el("div", { class: "more" }, el("p", {}, see), el("h3", {}, "Try"), el("ol", {}, ...items)),
  ];
}
