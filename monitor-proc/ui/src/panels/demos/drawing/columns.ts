// The columns of a stack side by side, each seen from the side and filled from below.
import { setAttr, svg } from "../../dom";
import { type Bin, binWords, flightWords } from "../bin-state";
import type { Drawing } from "./index";
import type { Slots } from "./slots";

const WIDE = 52;
const HIGH = 22;
const GAP = 8;
const NEAR_M = 0.06;
/** Columns in a row of the drawing. */
const IN_A_ROW = 9;

export function columnDrawing({ places, levels, base_m }: Slots, first: Bin | undefined): Drawing {
  const high_m = first?.size[2] ?? 0.135;
  const cells = places.map((_, column) => Array.from({ length: levels }, (_, level) => cell(column, level, levels)));
  const under = { y: levels * HIGH + 16, "text-anchor": "middle" };
  const names = places.map((_, column) => svg("text", { x: middle(column), ...under }, String(column + 1)));
  const [width, height] = [Math.min(places.length, IN_A_ROW) * (WIDE + GAP) + GAP, levels * HIGH + 24];
  const ground = svg("path", { class: "ground", d: `M0 ${levels * HIGH + 3}H${width}` });
  const attrs = { class: "job-drawing column-drawing", role: "img", viewBox: `0 0 ${width} ${height}` };
  const root = svg("svg", attrs, ground, ...cells.flat().map(({ node }) => node), ...names);
  const show = (all: Bin[]) => {
    for (const one of cells.flat()) one.set(null);
    for (const bin of all) {
      const [column, level] = placeOf(bin);
      if (bin.place === "placed") cells[column]?.[level]?.set(bin);
    }
    setAttr(root, "aria-label", words(all));
  };
  const placeOf = ({ pose }: Bin): [number, number] => {
    if (pose === null) return [-1, -1];
    const column = places.findIndex(([x, y]) => Math.hypot(pose[0] - x, pose[1] - y) < NEAR_M);
    return [column, Math.round((pose[2] - base_m) / high_m - 0.5)];
  };
  const words = (all: Bin[]) => {
    const counts = cells.map((column) => column.filter((one) => one.isFilled()).length);
    const filled = counts.reduce((sum, count) => sum + count, 0);
    const columns = counts.map((count, index) => `column ${index + 1}: ${count}`).join(", ");
    return `Columns from the side: ${filled} of ${places.length * levels} places are filled; ${columns} of ${levels}. ${flightWords(all)}`;
  };
  return { title: "Columns from the side", root, show };
}

function middle(column: number): number {
  return GAP + column * (WIDE + GAP) + WIDE / 2;
}

function cell(column: number, level: number, levels: number) {
  const [x, y] = [middle(column) - WIDE / 2, (levels - 1 - level) * HIGH];
  const title = svg("title");
  const label = svg("text", { x: middle(column), y: y + HIGH / 2, dy: "0.35em", "text-anchor": "middle" });
  const box = svg("rect", { x, y: y + 1, width: WIDE, height: HIGH - 2, rx: 2 });
  const cross = svg("path", { d: `M${x} ${y + 1}l${WIDE} ${HIGH - 2}m0 ${2 - HIGH}l${-WIDE} ${HIGH - 2}` });
  const node = svg("g", { class: "bin", "data-column": column, "data-level": level }, title, box, cross, label);
  return {
    node,
    isFilled: () => node.hasAttribute("data-place"),
    set(bin: Bin | null) {
      setAttr(node, "data-place", bin?.place ?? null);
      cross.style.display = bin?.isFlipped === true ? "" : "none";
      label.textContent = bin === null ? "" : bin.name.replace(/^bin_?/, "");
      title.textContent = bin === null ? "empty" : binWords(bin);
    },
  };
}
