// The selection: a card under the scene, and in a narrow window a button over the
// view that opens the drawer with it.
import type { Scene } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, plainButton, setText } from "../dom";
import { openDrawer } from "../drawers";
import { armCard } from "./arm";
import { fixtureCard } from "./fixture";
import { objectCard } from "./object";
import type { Row } from "./rows";

export interface Card {
  kind: string;
  rows: Row[];
  actions: HTMLElement[];
}

export function inspector(context: PanelContext): HTMLElement {
  const name = el("h3", {});
  const kind = el("span", { class: "dim" });
  const body = el("div", { class: "inspect-body" });
  const attrs = { class: "button icon-only quiet", title: "Close (Escape)", "aria-label": "Close the card" };
  const close = plainButton(attrs, () => leave(context), "×");
  const head = el("header", { class: "row" }, el("div", { class: "inspect-name" }, name, kind), close);
  const root = el("section", { class: "inspect", "aria-label": "Selected", hidden: true }, head, body);
  const chip = detailsButton();
  let rows: Row[] = [];
  const show = () => {
    for (const row of rows) row.show();
  };
  const fill = (wanted: string | null) => {
    const card = wanted === null ? null : cardOf(context, wanted);
    root.hidden = chip.hidden = card === null;
    rows = card?.rows ?? [];
    const actions = el("div", { class: "inspect-actions" }, ...(card?.actions ?? []));
    body.replaceChildren(...rows.map(({ node }) => node), actions);
    setText(name, wanted ?? "");
    setText(kind, card?.kind ?? "");
    setText(chip, `${wanted ?? ""}: details`);
    show();
  };
  root.addEventListener("keydown", (event) => {
    if (event.key === "Escape") leave(context);
  });
  addEventListener("keydown", (event) => {
    const target = event.target instanceof Element ? event.target : null;
    if (event.key === "Escape" && target?.closest("dialog, .popover, input, .inspect") == null) context.select(null);
  });
  context.onSelect(fill);
  // The same scene comes again after a reconnection.
  context.store.on("scene", () => fill(context.selection));
  context.pulse.add(root, show);
  return root;
}

/** Closes the card; the focus goes back to the row of the scene it came from. */
function leave(context: PanelContext): void {
  const row = document.querySelector<HTMLElement>('.tree-row[aria-current="true"]');
  context.select(null);
  row?.focus();
}

function detailsButton(): HTMLElement {
  const open = () => {
    openDrawer("left");
    document.querySelector(".inspect")?.scrollIntoView({ block: "nearest" });
  };
  const chip = plainButton({ class: "button details-chip", hidden: true }, open);
  // It is over the view, which would take a press as one of its own.
  for (const kind of ["click", "dblclick", "pointerdown"])
    chip.addEventListener(kind, (event) => event.stopPropagation());
  document.getElementById("view")?.append(chip);
  return chip;
}

function cardOf(context: PanelContext, name: string): Card | null {
  const { scene } = context.store;
  if (scene === null) return null;
  const at = (list: Scene["objects" | "arms" | "fixtures"]) => list.findIndex((one) => one.name === name);
  const [object, arm, fixture] = [at(scene.objects), at(scene.arms), at(scene.fixtures)];
  if (object >= 0) return objectCard(context, object);
  return arm >= 0 ? armCard(context, arm) : fixtureCard(context, fixture);
}
