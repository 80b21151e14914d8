// How often each delay occurred: time to the right and counts upwards, both in
// powers of ten, as the rare ones matter.
import type { HopLatency } from "../../net/protocol";
import { svg } from "../dom";
import { micros } from "../format";

const WIDTH = 320;
const HEIGHT = 64;
const BASE = HEIGHT - 14;

/** A power of ten of microseconds. */
function decade(power: number): string {
  if (power < 3) return `${10 ** power} µs`;
  return power < 6 ? `${10 ** (power - 3)} ms` : `${10 ** (power - 6)} s`;
}

/** The figures, for a screen reader. */
function summary(hop: HopLatency): string {
  const figures = [`p50 ${micros(hop.p50_us)}`, `p99 ${micros(hop.p99_us)}`, `max ${micros(hop.max_us)}`];
  return `${hop.hop}: ${figures.join(", ")} of ${hop.n}`;
}

export function histogram(hop: HopLatency): SVGSVGElement {
  const attrs = { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "histogram", preserveAspectRatio: "none", role: "img" };
  const root = svg("svg", { ...attrs, "aria-label": summary(hop) });
  const counted = hop.buckets.filter(([, count]) => count > 0);
  const most = Math.max(...counted.map(([, count]) => count), 1);
  // A bucket is known by its upper end only: the median may be left of the first.
  const first = Math.log10(Math.max(Math.min(...counted.map(([upper]) => upper), hop.p50_us, 1e9), 1));
  const last = Math.log10(Math.max(...counted.map(([upper]) => upper), 10));
  const low = Math.floor(Math.min(first, last - 0.1));
  const high = Math.ceil(last + 0.01);
  const x = (us: number) => (WIDTH * (Math.log10(Math.max(us, 1)) - low)) / (high - low);
  for (let power = low; power <= high; power++) {
    const at = x(10 ** power);
    root.append(svg("line", { x1: at, x2: at, y1: 0, y2: BASE, class: "grid" }));
    const anchor = power === low ? "start" : power === high ? "end" : "middle";
    root.append(svg("text", { x: at, y: HEIGHT - 3, "text-anchor": anchor }, decade(power)));
  }
  const [one, two] = hop.buckets;
  // The first bucket is as wide as the second, on this scale.
  let before = one === undefined ? 1 : two === undefined ? one[0] / 2 : one[0] ** 2 / two[0];
  for (const [upper, count] of hop.buckets) {
    if (count > 0) {
      const height = Math.max((BASE * Math.log10(1 + count)) / Math.log10(1 + most), 1.5);
      const left = x(Math.min(before, upper));
      const width = Math.max(x(upper) - left - 0.6, 1.4);
      const bar = svg("rect", { x: left, y: BASE - height, width, height, class: "bar" });
      bar.append(svg("title", {}, `up to ${micros(upper)}: ${count}`));
      root.append(bar);
    }
    before = upper;
  }
  for (const [name, us] of Object.entries({ p50: hop.p50_us, p99: hop.p99_us })) {
    const title = svg("title", {}, `${name} ${micros(us)}`);
    root.append(svg("line", { x1: x(us), x2: x(us), y1: 0, y2: BASE, class: `mark ${name}` }, title));
  }
  return root;
}
