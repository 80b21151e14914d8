// One column of a loop over time, with a line at each event.
import uPlot from "uplot";
import { el } from "../dom";
import { ticks } from "../ticks";

const HEIGHT = 90;
const AXIS = "#93a1b1";
const GRID = { stroke: "#232c36", width: 1 };
const LINE = "#58a6ff";
const EVENT = "#ff7b72";

/** Cycles further apart than this were not measured one after the other, as multiples of the usual distance. */
const GAP = 20;

/** The columns with a missing value where nothing was measured. */
function withGaps(at_ms: number[], values: number[]): [number[], (number | null)[]] {
  const apart = at_ms.slice(1).map((at, index) => at - (at_ms[index] ?? at));
  const usual = [...apart].sort((a, b) => a - b)[Math.floor(apart.length / 2)] ?? 0;
  const [times, shown]: [number[], (number | null)[]] = [[], []];
  at_ms.forEach((at, index) => {
    if (index > 0 && (apart[index - 1] ?? 0) > GAP * usual) {
      times.push(at);
      shown.push(null);
    }
    times.push(at);
    shown.push(values[index] ?? null);
  });
  return [times, shown];
}

export function chart(
  at_ms: number[],
  values: number[],
  { width, span, marks }: { width: number; span: [number, number]; marks: number[] },
): HTMLElement {
  const host = el("div", { class: "incident-chart" });
  const axis = { stroke: AXIS, grid: GRID, ticks: GRID, font: "10px system-ui" };
  const options: uPlot.Options = {
    width: Math.max(width - 24, 200),
    height: HEIGHT,
    legend: { show: false },
    cursor: { y: false },
    scales: { x: { time: false, range: () => span } },
    axes: [
      { ...axis, size: 24, values: ticks("ms") },
      { ...axis, size: 46, values: ticks() },
    ],
    series: [{}, { stroke: LINE, width: 1, points: { show: false } }],
    hooks: {
      draw: [
        ({ ctx, bbox, valToPos }) => {
          ctx.fillStyle = EVENT;
          for (const mark of marks) ctx.fillRect(valToPos(mark, "x", true), bbox.top, 1, bbox.height);
        },
      ],
    },
  };
  new uPlot(options, withGaps(at_ms, values), host);
  return host;
}
