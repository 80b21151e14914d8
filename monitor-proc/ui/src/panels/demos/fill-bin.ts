// Fill a bin: drop parts, and see how much the cup still bears.
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setText } from "../dom";
import { dropParts } from "./answers";
import { loadChart } from "./load/chart";
import { suctionGauge } from "./suction";

export function mountFillBin(context: PanelContext, element: HTMLElement): () => void {
  const { store } = context;
  const parts = el("b", { class: "num" });
  const inBin = el("span", { class: "dim" });
  const total = store.scene?.objects.filter(({ shape }) => shape.kind !== "bin").length ?? 0;
  const load = loadChart(context);
  element.append(
    el("p", { class: "row" }, parts, ` of ${total} parts were dropped`, inBin),
    button(context, {
      label: "Drop parts",
      about: () => `Drop ${store.scene?.dispenser?.per_drop ?? 1} parts, at any time`,
      twin: () => "robocell drop-parts",
      why: () => context.cellRefusal(),
      run: () => dropParts(context),
    }),
    el("h3", {}, "Gripper"),
    suctionGauge(context),
    load.root,
  );
  const show = () => {
    const found = store.status?.equipment;
    setText(parts, String(found?.parts_dropped ?? 0));
    const [waiting, cleared] = [found?.parts_waiting ?? 0, found?.cleared ?? 0];
    const isEnd = store.isTaskOver;
    const rest = waiting > 0 ? `, ${waiting} ${isEnd ? "not used" : "to come"}` : "";
    setText(inBin, rest + (cleared > 0 ? `, ${cleared} out of the cell` : ""));
  };
  show();
  const off = store.on("status", show);
  return () => {
    off();
    load.stop();
  };
}
