// The pallet from above: its slots, and each bin over it as it is turned. As the view's
// camera from above has it, x points up and y to the left.
import type { Pose } from "../../../net/protocol";
import { setAttr, svg } from "../../dom";
import { type Bin, binWords, flightWords } from "../bin-state";
import type { Drawing } from "./index";
import type { Slots } from "./slots";

/** Units of the drawing to a metre. */
const SCALE = 300;
const MARGIN_M = 0.2;
const NEAR_M = 0.05;

export function palletDrawing({ places }: Slots, first: Bin | undefined): Drawing {
  const [long, wide] = [first?.size[0] ?? 0.3, first?.size[1] ?? 0.2];
  const [xs, ys] = [places.map(([x]) => x), places.map(([, y]) => y)];
  const [top, left] = [Math.max(...xs) + MARGIN_M, Math.max(...ys) + MARGIN_M];
  const [height, width] = [top - Math.min(...xs) + MARGIN_M, left - Math.min(...ys) + MARGIN_M];
  const at = (x: number, y: number): [number, number] => [SCALE * (left - y), SCALE * (top - x)];
  const whole = { width: SCALE * width, height: SCALE * height };
  const inner = { x: 8, y: 8, width: whole.width - 16, height: whole.height - 16 };
  const pallet = svg("rect", { class: "pallet", ...inner, rx: 6 });
  const slot = { width: SCALE * long, height: SCALE * wide };
  const slots = places.map(([x, y]) => {
    const [u, v] = at(x, y);
    return svg("rect", { class: "slot-mark", x: u - slot.width / 2, y: v - slot.height / 2, ...slot });
  });
  const bins = svg("g");
  const viewBox = `0 0 ${whole.width} ${whole.height}`;
  const attrs = { class: "job-drawing pallet-drawing", role: "img", viewBox };
  const root = svg("svg", attrs, pallet, ...slots, bins);
  const show = (all: Bin[]) => {
    const shown = all.filter(({ pose }) => pose !== null && isOver(pose[0], pose[1]));
    bins.replaceChildren(...shown.map((bin) => drawn(bin, at)));
    setAttr(root, "aria-label", words(all));
  };
  const isOver = (x: number, y: number) => x < top && x > top - height && y < left && y > left - width;
  const words = (all: Bin[]) => {
    const isInSlot = ([u, v]: Pose) => places.some(([x, y]) => Math.hypot(u - x, v - y) < NEAR_M);
    const filled = all.filter(({ place, pose }) => place === "placed" && pose !== null && isInSlot(pose));
    const names = filled.length === 0 ? "" : `: ${filled.map(binWords).join("; ")}`;
    return `Pallet from above: ${filled.length} of ${places.length} slots are filled${names}. ${flightWords(all)}`;
  };
  return { title: "Pallet from above", root, show };
}

/** A bin as it is turned, with its name; a cross where it is upside down. */
function drawn(bin: Bin, at: (x: number, y: number) => [number, number]): SVGElement {
  const [x, y, , w, qx, qy, qz] = bin.pose ?? [0, 0, 0, 1, 0, 0, 0];
  const [u, v] = at(x, y);
  // Where the long side points, seen from above.
  const along: [number, number] = [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + w * qz)];
  const turn = (180 / Math.PI) * Math.atan2(-along[0], -along[1]);
  const [long, wide] = [SCALE * bin.size[0], SCALE * bin.size[1]];
  const box = { x: -long / 2, y: -wide / 2, width: long, height: wide, rx: 3 };
  const d = `M${box.x} ${box.y}L${-box.x} ${-box.y}M${box.x} ${-box.y}L${-box.x} ${box.y}`;
  const cross = bin.isFlipped ? svg("path", { d }) : null;
  const body = svg("g", { transform: `rotate(${turn.toFixed(1)})` }, svg("rect", box), cross);
  const label = svg("text", { "text-anchor": "middle", dy: "0.35em" }, bin.name);
  const transform = `translate(${u.toFixed(1)} ${v.toFixed(1)})`;
  const attrs = { class: "bin", "data-place": bin.place, "data-name": bin.name, transform };
  return svg("g", attrs, svg("title", {}, binWords(bin)), body, label);
}
