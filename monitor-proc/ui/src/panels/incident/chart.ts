// One column of a loop over time, with a line at each event.
import uPlot from "uplot";
import { el } from "../dom";
import { AXIS, LINE, ticks } from "../ticks";

const HEIGHT = 90;
const COLOUR = "#58a6ff";
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
  const options: uPlot.Options = {
    width: Math.max(width - 24, 200),
    height: HEIGHT,
    legend: { show: false },
    cursor: { y: false },
    scales: { x: { time: false, range: () => span } },
    axes: [
      { ...AXIS, size: 24, values: ticks("ms") },
      { ...AXIS, size: 46, values: ticks() },
    ],
    series: [{}, { ...LINE, stroke: COLOUR, width: 1 }],
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
