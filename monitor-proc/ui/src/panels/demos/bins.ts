// Bins off a conveyor: the belt, a button for another bin, and who stands where.
import type { Desk } from "../desk";
import { button } from "../button";
import { el, setAttr, setText } from "../dom";
import { OBJECT } from "../../net/snapshot";
import { suctionGauge } from "./suction";

/** Whether a bin with this orientation (w, x, y, z) opens upward. */
function opensUp([, , , , x, y]: number[]): boolean {
  return 1 - 2 * ((x ?? 0) ** 2 + (y ?? 0) ** 2) > 0;
}

export function mountBins(desk: Desk, element: HTMLElement): () => void {
  const { store } = desk;
  const bins = store.scene?.objects.map((object, index) => ({ ...object, index })).filter(({ shape }) => shape.kind === "bin") ?? [];
  const count = el("b", { class: "num" });
  const belt = el("span", { class: "badge" });
  const refusal = el("span", { class: "dim" });
  const cells = bins.slice(0, store.scene?.bins).map(({ name, index }) => {
    const state = el("span", { class: "dim" });
    return { name, index, state, node: el("div", { class: "cube-row" }, el("span", {}, name), state) };
  });
  const add = (flipped: boolean) =>
    button(desk, {
      label: flipped ? "Add bin, upside down" : "Add bin",
      about: () => (flipped ? "Let a bin come that opens downward" : "Let another bin come"),
      twin: () => (flipped ? "robocell add-bin --flipped" : "robocell add-bin"),
      why: () => desk.cellRefusal(),
      run: async () => {
        if (await desk.send({ do: "add_bin", flipped })) sayNext(desk, bins);
      },
    });
  const map = slotMap(desk);
  element.append(
    el("p", { class: "row" }, count, ` of ${cells.length} bins are placed`, el("span", { class: "spacer" }), "Belt", belt),
    el("div", { class: "row" }, add(false), add(true)),
    refusal,
    ...(map === null ? [] : [el("h3", {}, "Slots, from above"), map.root]),
    el("h3", {}, "Gripper"),
    suctionGauge(desk),
    el("h3", {}, "Bins"),
    el("div", { class: "cube-list" }, ...cells.map(({ node }) => node)),
  );
  const show = () => {
    const placed = new Set(store.status?.task.placed ?? []);
    const found = store.status?.equipment;
    const held = store.snapshot?.arms[0]?.held ?? null;
    setText(count, String(placed.size));
    const runs = (found?.conveyor_speed_m_s ?? 0) > 0;
    setText(belt, runs ? `${(found?.conveyor_speed_m_s ?? 0).toFixed(2)} m/s` : "stands");
    setAttr(belt, "data-tone", runs ? "ok" : null);
    setText(refusal, found && found.supply_refusals > 0 ? `A bin was refused ${found.supply_refusals} times: ${found.supply_refusal}.` : "");
    for (const { name, index, state, node } of cells) {
      const object = store.snapshot?.objects[index];
      const here = object !== undefined && (object.flags & OBJECT.enabled) !== 0;
      const word = !here ? "to come" : held === index ? "held" : placed.has(name) ? "placed" : "in the cell";
      const side = here && object !== undefined ? (opensUp(object.pose) ? ", opens up" : ", upside down") : "";
      setText(state, word + side);
      setAttr(node, "data-state", word === "held" ? "carried" : word === "placed" ? "placed" : "waits");
    }
    map?.show();
  };
  show();
  const off = [store.on("status", show)];
  return () => off.forEach((one) => one());
}

/** Says which bin comes, as soon as it is there. */
function sayNext(desk: Desk, bins: { name: string; index: number }[]): void {
  const isHere = (index: number) => ((desk.snapshot?.objects[index]?.flags ?? 0) & OBJECT.enabled) !== 0;
  const before = new Set(bins.filter(({ index }) => isHere(index)).map(({ name }) => name));
  const off = desk.store.on("snapshot", ({ objects }) => {
    const added = bins.find(({ name, index }) => !before.has(name) && isHere(index));
    if (added === undefined) return;
    off();
    const up = opensUp(objects[added.index]?.pose ?? []);
    desk.say(`Added ${added.name}, ${up ? "opens up" : "upside down"}`);
  });
  setTimeout(off, WAIT_MS);
}

/** A bin that is not there by then was not added. */
const WAIT_MS = 120_000;
const SLOT_NEAR_M = 0.05;
/** Columns along each side of a stack. */
const STACK_SIDE = 3;

/** The slots seen from above, each with how many bins stand in it; null where the
 * cell file says nothing of slots. */
function slotMap(desk: Desk): { root: HTMLElement; show: () => void } | null {
  const { store } = desk;
  const slots = slotsOf(store.scene?.task);
  if (slots.length === 0) return null;
  const columns = [...new Set(slots.map(([x]) => x))].sort((a, b) => b - a);
  const rows = [...new Set(slots.map(([, y]) => y))].sort((a, b) => a - b);
  const cells = slots.map(([x, y]) => {
    const node = el("div", { class: "slot num" });
    node.style.gridColumn = String(rows.indexOf(y) + 1);
    node.style.gridRow = String(columns.indexOf(x) + 1);
    return { x, y, node };
  });
  const root = el("div", { class: "slots" }, ...cells.map(({ node }) => node));
  root.style.gridTemplateColumns = `repeat(${rows.length}, 1fr)`;
  const show = () => {
    const placed = new Set(store.status?.task.placed ?? []);
    for (const { x, y, node } of cells) {
      let count = 0;
      store.scene?.objects.forEach(({ name }, index) => {
        const pose = store.snapshot?.objects[index]?.pose;
        if (pose === undefined || !placed.has(name)) return;
        if (Math.hypot(pose[0] - x, pose[1] - y) < SLOT_NEAR_M) count += 1;
      });
      setText(node, count === 0 ? "" : String(count));
      setAttr(node, "data-state", count > 0 ? "placed" : null);
    }
  };
  return { root, show };
}

/** Slots as the cell file gives them: a grid of `slot_x_m` and `slot_y_m`, or a
 * `stack` of columns at `first_m` and steps from there. */
function slotsOf(task: Record<string, unknown> | undefined): [number, number][] {
  const [xs, ys] = [numbers(task?.["slot_x_m"]), numbers(task?.["slot_y_m"])];
  const grid = xs.flatMap((x) => ys.map((y): [number, number] => [x, y]));
  const stack = task?.["stack"];
  if (grid.length > 0 || typeof stack !== "object" || stack === null) return grid;
  const [first, one, two] = ["first_m", "first_step_m", "second_step_m"].map((key) => numbers((stack as Record<string, unknown>)[key]));
  if (first === undefined || first.length < 2 || one?.length !== 2 || two?.length !== 2) return [];
  const steps = Array.from({ length: STACK_SIDE }, (_, step) => step);
  const along = (axis: 0 | 1, i: number, j: number) => round((first[axis] ?? 0) + i * (one[axis] ?? 0) + j * (two[axis] ?? 0));
  return steps.flatMap((i) => steps.map((j): [number, number] => [along(0, i, j), along(1, i, j)]));
}

function numbers(value: unknown): number[] {
  return Array.isArray(value) ? value.filter((one): one is number => typeof one === "number") : [];
}

/** To a tenth of a millimetre: slots of one row are to have the same number. */
function round(metres: number): number {
  return Math.round(metres * 1e4) / 1e4;
}
