// Bins off a conveyor: the belt, a button for another bin, and where each bin is.
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setText, spacer } from "../dom";
import { addBin } from "./answers";
import { type BinPlace, binsOf, flightWords } from "./bin-state";
import { jobDrawing } from "./drawing/index";
import { suctionGauge } from "./suction";

/** Places of a bin that the style sheet knows, by its name for them. */
const STATES: Partial<Record<BinPlace, string>> = { "in flight": "carried", placed: "placed" };

export function mountBins(context: PanelContext, element: HTMLElement): () => void {
  const { store } = context;
  const count = el("b", { class: "num" });
  const belt = el("span", { class: "badge" });
  const refusal = el("span", { class: "dim" });
  const flight = el("p", { class: "dim" });
  const cells = binsOf(store).map(({ name }) => {
    const state = el("span", { class: "dim" });
    return { state, node: el("div", { class: "cube-row" }, el("span", {}, name), state) };
  });
  const add = (flipped: boolean) =>
    button(context, {
      label: flipped ? "Add bin, upside down" : "Add bin",
      about: () => (flipped ? "Add a bin that opens downward" : "Add another bin"),
      twin: () => (flipped ? "robocell add-bin --flipped" : "robocell add-bin"),
      why: () => context.cellRefusal(),
      run: () => addBin(context, flipped),
    });
  const drawing = jobDrawing(store);
  element.append(
    el("p", { class: "row" }, count, ` of ${cells.length} bins are placed`, spacer(), "Belt", belt),
    el("div", { class: "row" }, add(false), add(true)),
    refusal,
    ...(drawing === null ? [] : [el("h3", {}, drawing.title), drawing.root, flight]),
    el("h3", {}, "Gripper"),
    suctionGauge(context),
    el("h3", {}, "Bins"),
    el("div", { class: "cube-list" }, ...cells.map(({ node }) => node)),
  );
  const show = () => {
    const found = store.status?.equipment;
    const bins = binsOf(store);
    setText(count, String(store.status?.task.placed.length ?? 0));
    const runs = (found?.conveyor_speed_m_s ?? 0) > 0;
    setText(belt, runs ? `${(found?.conveyor_speed_m_s ?? 0).toFixed(2)} m/s` : "stopped");
    setAttr(belt, "data-tone", runs ? "ok" : null);
    const refused = found?.supply_refusals ?? 0;
    setText(refusal, refused > 0 ? `A bin was refused ${refused} times: ${found?.supply_refusal}.` : "");
    for (const [index, { state, node }] of cells.entries()) {
      const bin = bins[index];
      if (bin === undefined) continue;
      const side = bin.pose === null ? "" : bin.isFlipped ? ", upside down" : ", opens up";
      setText(state, bin.place + side);
      setAttr(node, "data-state", STATES[bin.place] ?? "waits");
    }
    setText(flight, flightWords(bins));
  };
  show();
  // A bin in flight moves more often than status is told.
  if (drawing !== null) context.pulse.add(drawing.root, () => drawing.show(binsOf(store)));
  return store.on("status", show);
}
