// Fill a bin: drop parts, and see how much the cup still bears.
import type { Desk } from "../desk";
import { button } from "../button";
import { el, setText } from "../dom";
import { suctionGauge } from "./suction";

/** Parts that did not fall by then were not dropped. */
const WAIT_MS = 120_000;

export function mountFillBin(desk: Desk, element: HTMLElement): () => void {
  const { store } = desk;
  const parts = el("b", { class: "num" });
  const inBin = el("span", { class: "dim" });
  const total = store.scene?.objects.filter(({ shape }) => shape.kind !== "bin").length ?? 0;
  const dropped = () => store.status?.equipment?.parts_dropped ?? 0;
  element.append(
    el("p", { class: "row" }, parts, ` of ${total} parts were dropped`, inBin),
    button(desk, {
      label: "Drop parts",
      about: () => `Drop ${store.scene?.dispenser?.per_drop ?? 1} parts, at any time`,
      twin: () => "robocell drop-parts",
      why: () => desk.cellRefusal(),
      run: async () => {
        const before = dropped();
        if (!(await desk.send({ do: "drop_parts", count: 0 }))) return;
        const off = store.on("status", () => {
          if (dropped() === before) return;
          off();
          desk.say(`Dropped parts: ${dropped()} of ${total} so far, ${store.status?.equipment?.parts_waiting ?? 0} to come`);
        });
        setTimeout(off, WAIT_MS);
      },
    }),
    el("h3", {}, "Gripper"),
    suctionGauge(desk),
  );
  const show = () => {
    const found = store.status?.equipment;
    setText(parts, String(found?.parts_dropped ?? 0));
    setText(inBin, found && found.parts_waiting > 0 ? `, ${found.parts_waiting} to come` : "");
  };
  show();
  const off = [store.on("status", show)];
  return () => off.forEach((one) => one());
}
