// The arms, objects and fixtures of the scene; a click selects one in the view.
import type { Scene } from "../../net/protocol";
import { OBJECT, type ObjectState } from "../../net/snapshot";
import type { PanelContext } from "../context";
import { jobBins } from "../demos/bin-state";
import { el, plainButton, setAttr, setText, setTitle } from "../dom";
import { css } from "../format";
import { isAtRest } from "../inspect/object";

type Refresh = () => void;

export function sceneTree(context: PanelContext): HTMLElement {
  const root = el("div", { class: "scene-tree" }, el("p", { class: "dim" }, "No scene yet."));
  let refreshes: Refresh[] = [];
  context.store.on("scene", (scene) => {
    refreshes = [];
    root.replaceChildren(
      group("Arms", arms(context, scene, refreshes)),
      group("Objects", objects(context, scene, refreshes)),
      group("Fixtures", fixtures(context, scene)),
    );
  });
  context.pulse.add(root, () => {
    for (const refresh of refreshes) refresh();
  });
  root.addEventListener("keydown", (event) => {
    if (event.key === "Escape") context.select(null);
  });
  context.onSelect((name) => mark(root, name));
  return root;
}

/** The objects that fell out of the cell, above everything else: no window is too low for them. */
export function lostList(context: PanelContext): HTMLElement {
  const root = el("div", { class: "lost-list", role: "status", hidden: true });
  let shown = "";
  context.pulse.add(null, () => {
    const { lost: gone, fallen, scene } = context.store;
    // Parts of a dispenser fall in normal operation: its panel counts them.
    const lost = scene?.dispenser == null ? [...gone, ...fallen] : gone;
    if (lost.join() === shown) return;
    shown = lost.join();
    root.hidden = lost.length === 0;
    const state = () => el("span", { class: "state", "data-tone": "bad" }, "lost");
    root.replaceChildren(...lost.map((name) => row(context, name, colourOf(context, name), state())));
  });
  return root;
}

function colourOf({ store }: PanelContext, name: string): string | null {
  const object = store.scene?.objects.find((one) => one.name === name);
  return object === undefined ? null : css(object.colour);
}

function group(name: string, rows: HTMLElement[]): HTMLElement {
  const head = el("summary", {}, name, el("span", { class: "dim count" }, String(rows.length)));
  return el("details", { open: true, class: "tree-group" }, head, ...rows);
}

function row(context: PanelContext, name: string, colour: string | null, state: HTMLElement): HTMLElement {
  const swatch = el("i", { class: "swatch" });
  if (colour !== null) swatch.style.background = colour;
  const attrs = { class: "tree-row", "data-name": name, title: `Select ${name}: its kind and its place` };
  const select = () => context.select(context.selection === name ? null : name);
  return plainButton(attrs, select, swatch, el("span", { class: "name" }, name), state);
}

/** Shows which row is selected, here or by a click in the view. */
function mark(root: HTMLElement, name: string | null): void {
  for (const node of root.querySelectorAll<HTMLElement>("[data-name]")) {
    setAttr(node, "aria-current", node.dataset.name === name ? "true" : null);
  }
}

function arms(context: PanelContext, scene: Scene, refreshes: Refresh[]): HTMLElement[] {
  return scene.arms.map((arm, index) => {
    const state = el("span", { class: "dim state" });
    refreshes.push(() => {
      const now = context.snapshot?.arms[index];
      const held = now?.held == null ? null : scene.objects[now.held]?.name;
      const words = now?.fault ? "fault" : held ? `holds ${held}` : "free";
      setText(state, words);
      setTitle(state, words);
    });
    return row(context, arm.name, null, state);
  });
}

function objects(context: PanelContext, scene: Scene, refreshes: Refresh[]): HTMLElement[] {
  const wanted = new Set(jobBins(scene));
  return scene.objects.map((object, index) => {
    // A cell may have more bins than its job: a person may ask for another one.
    const isSpare = object.shape.kind === "bin" && !wanted.has(object.name);
    const state = el("span", { class: "dim state" });
    let before = "";
    refreshes.push(() => {
      const now = context.snapshot?.objects[index];
      if (!now) return;
      const isStill = isAtRest(now);
      const holder = context.snapshot?.arms.findIndex((arm) => arm.held === index) ?? -1;
      // A hundred rows ten times a second: to ask the page for their texts takes longer.
      const isFallen = context.store.fallen.includes(object.name);
      const isEnd = context.store.isTaskOver;
      const key = `${now.flags} ${holder} ${isFallen} ${isEnd} ${isStill} ${Math.round(1000 * now.pose[2])}`;
      if (key === before) return;
      before = key;
      const isPart = scene.dispenser != null;
      const away = isFallen ? "out of the cell" : isEnd || isSpare ? "not used" : "to come";
      const absent = object.parked !== true || (isFallen && !isPart) ? "lost" : away;
      const by = holder < 0 ? null : scene.arms.length > 1 ? ` by ${context.armName(holder)}` : "";
      const words = objectState(now, absent, by, isStill);
      setText(state, words);
      // It is cut where there is little room.
      setTitle(state, words);
      setAttr(state, "data-tone", words === "lost" ? "bad" : null);
    });
    return row(context, object.name, css(object.colour), state);
  });
}

function objectState({ flags, pose }: ObjectState, absent: string, holder: string | null, isStill: boolean): string {
  if ((flags & OBJECT.enabled) === 0) return absent;
  const words = [];
  // One arm needs no name where there is little room.
  if (holder !== null) words.push(`held${holder}`);
  else if ((flags & OBJECT.dragged) !== 0) words.push("dragged");
  else if ((flags & OBJECT.touched) !== 0) words.push("touched");
  else if (isStill) words.push("at rest");
  words.push(`z ${pose[2].toFixed(3)} m`);
  return words.join(" · ");
}

function fixtures(context: PanelContext, scene: Scene): HTMLElement[] {
  return scene.fixtures.map((fixture) => {
    const about = fixture.obstacle === null ? "" : `obstacle ${fixture.obstacle}`;
    return row(context, fixture.name, css(fixture.colour), el("span", { class: "dim state" }, about));
  });
}
