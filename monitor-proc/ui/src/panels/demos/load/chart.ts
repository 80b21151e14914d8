// The load of a suction cup over time, against the limit at which its grip breaks.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { PanelContext } from "../../context";
import { el, setText } from "../../dom";
import { AXIS, LINE, ticks } from "../../ticks";
import { LoadHistory } from "./history";

const HEIGHT = 170;
/** The load axis ends here (% of the limit). */
const TOP = 125;
const LOAD = "#58a6ff";
const FORCE = "#4cc38a";
const LIMIT = "#ff7b72";
const CURSOR = "#ffffff";

export interface LoadChart {
  root: HTMLElement;
  stop: () => void;
}

/** For the first arm. */
export function loadChart(context: PanelContext): LoadChart {
  const history = new LoadHistory(context.store, 0);
  const limit_n = context.store.scene?.arms[0]?.gripper?.force_limit_n ?? 0;
  const area = el("div", { class: "load-area", role: "img" });
  const words = el("p", { class: "dim" });
  const load = "load (% of the limit of force or torque)";
  const keys = [key(LOAD), load, key(FORCE), "force (N)", key(LIMIT), "grip lost"];
  const legend = el("p", { class: "dim load-legend" }, ...keys);
  const chart = new uPlot(options(history, limit_n, area), [[], [], []], area);
  new ResizeObserver(() => {
    if (area.clientWidth > 0) chart.setSize({ width: area.clientWidth, height: HEIGHT });
  }).observe(area);
  const root = el("div", { class: "load-chart" }, el("h3", {}, "Load over time"), area, legend, words);
  // For browser tests.
  const breaks = () => history.breaks.length;
  Object.assign(root, { load: { data: () => chart.data, breaks, cursor: () => history.cursor } });
  context.pulse.add(root, () => {
    history.follow();
    const { samples } = history;
    chart.setData([
      samples.map(({ time_s }) => time_s),
      samples.map(({ load }) => (load === null ? null : 100 * load)),
      samples.map(({ force_n }) => force_n),
    ]);
    const said = summary(history, limit_n);
    setText(words, said);
    area.setAttribute("aria-label", `Load over time. ${said}`);
  });
  return { root, stop: history.stop };
}

function key(colour: string): HTMLElement {
  const swatch = el("i", { class: "swatch" });
  swatch.style.background = colour;
  return swatch;
}

function summary(history: LoadHistory, limit_n: number): string {
  const [from, to] = history.span;
  const most = Math.max(0, ...history.samples.map(({ load }) => load ?? 0));
  const count = history.breaks.length;
  const often = count === 0 ? "not lost" : count === 1 ? "lost once" : `lost ${count} times`;
  return `${from.toFixed(0)} to ${to.toFixed(0)} s: at most ${(100 * most).toFixed(0)} % of the break limit (force: ${limit_n.toFixed(0)} N); the grip was ${often}.`;
}

function options(history: LoadHistory, limit_n: number, area: HTMLElement): uPlot.Options {
  return {
    width: Math.max(area.clientWidth, 200),
    height: HEIGHT,
    legend: { show: false },
    cursor: { y: false, drag: { x: false, y: false } },
    scales: {
      x: { time: false, range: () => history.span },
      y: { range: [0, TOP] },
      force: { range: [0, (TOP / 100) * Math.max(limit_n, 1)] },
    },
    axes: [
      { ...AXIS, size: 26, values: ticks("s") },
      { ...AXIS, size: 46, values: ticks("%") },
      { ...AXIS, scale: "force", side: 1, size: 46, grid: { show: false }, values: ticks("N") },
    ],
    series: [{}, { ...LINE, stroke: LOAD }, { ...LINE, stroke: FORCE, scale: "force", dash: [4, 3] }],
    hooks: { draw: [(chart) => drawMarks(chart, history)] },
  };
}

/** The limit, each moment the grip broke, and the moment that is looked at. */
function drawMarks(chart: uPlot, history: LoadHistory): void {
  const { ctx, bbox } = chart;
  const y = chart.valToPos(100, "y", true);
  const ratio = window.devicePixelRatio;
  ctx.save();
  ctx.fillStyle = LIMIT;
  ctx.fillRect(bbox.left, y, bbox.width, ratio);
  ctx.font = `${11 * ratio}px system-ui`;
  ctx.fillText("break limit", bbox.left + 6 * ratio, y - 4 * ratio);
  const upright = (time_s: number, colour: string, width: number) => {
    const x = chart.valToPos(time_s, "x", true);
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.fillStyle = colour;
    ctx.fillRect(x, bbox.top, width * ratio, bbox.height);
  };
  for (const { time_s } of history.breaks) upright(time_s, LIMIT, 2);
  if (history.cursor !== null) upright(history.cursor, CURSOR, 1);
  ctx.restore();
}
