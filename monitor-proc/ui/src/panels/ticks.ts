// The axes of plots and their labels.
import type uPlot from "uplot";

const GRID = { stroke: "#232c36", width: 1 };
/** The look of all axes. */
export const AXIS = { stroke: "#93a1b1", grid: GRID, ticks: GRID, font: "10px system-ui" };
/** A line through the samples. */
export const LINE = { width: 1.5, points: { show: false } };

const MOST_DIGITS = 9;

/** Decimals that tell multiples of `step` apart. */
function digitsOf(step: number): number {
  for (let digits = 0; digits < MOST_DIGITS; digits++) {
    const scaled = step * 10 ** digits;
    if (scaled >= 1 - 1e-6 && Math.abs(scaled - Math.round(scaled)) < 1e-6 * scaled) return digits;
  }
  return MOST_DIGITS;
}

/** Writes ticks with as many decimals as their step needs, and `unit`. */
export function ticks(unit = ""): uPlot.Axis.DynamicValues {
  return (_plot, splits, _axis, _space, step) => splits.map((value) => tick(value, step, unit));
}

function tick(value: number | null, step: number, unit: string): string {
  if (value === null) return "";
  const text = value.toFixed(digitsOf(step)).replace(/^-(0\.?0*)$/, "$1");
  return unit === "" ? text : `${text} ${unit}`;
}
