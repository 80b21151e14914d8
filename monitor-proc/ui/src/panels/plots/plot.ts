// One plot of several signals.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { el, plainButton, spacer } from "../dom";
import { AXIS, LINE, ticks } from "../ticks";
import type { History } from "./history";

/** Distinct also for colour-blind readers. */
const COLOURS = ["#58a6ff", "#f0a53a", "#4cc38a", "#d2a8ff", "#ff7b72", "#79e0e8", "#e3d26f", "#c9d1d9"];
const CURSOR = "#ffffff";
const TYPE = "text/x-robocell-signal";

export class Plot {
  readonly root = el("div", { class: "plot", tabindex: 0, "aria-label": "Plot" });
  keys: string[];
  private readonly chips = el("div", { class: "chips" });
  private readonly area = el("div", { class: "plot-area" });
  private chart: uPlot | null = null;
  /** Labels of the value axis. */
  private labels: string[] = [];

  constructor(
    private readonly history: History,
    keys: string[],
    private readonly changed: () => void,
    private readonly seek: (time: number) => void,
    onRemove: () => void,
  ) {
    this.keys = keys;
    const about = "Remove this plot";
    const remove = plainButton({ class: "button icon-only quiet", title: about, "aria-label": about }, onRemove, "×");
    this.root.append(el("div", { class: "row" }, this.chips, spacer(), remove), this.area);
    new ResizeObserver(() => this.resize()).observe(this.area);
    this.root.addEventListener("dragover", (event) => {
      if (event.dataTransfer?.types.includes(TYPE)) event.preventDefault();
    });
    this.root.addEventListener("drop", (event) => {
      const key = event.dataTransfer?.getData(TYPE);
      if (key === undefined || key === "") return;
      event.preventDefault();
      this.add(key);
    });
    // For browser tests.
    const data = () => this.chart?.data ?? [[]];
    Object.assign(this.root, { plot: { data, cursor: () => this.history.cursor, labels: () => this.labels } });
    this.rebuild();
  }

  add(key: string): void {
    if (this.keys.includes(key) || this.keys.length >= COLOURS.length) return;
    this.keys.push(key);
    this.rebuild();
    this.changed();
  }

  /** Takes out the signals that are none of this scene; whether one is left. */
  prune(): boolean {
    this.keys = this.keys.filter((key) => this.history.find(key) !== undefined);
    this.rebuild();
    return this.keys.length > 0;
  }

  show(): void {
    if (this.chart === null) return;
    const data = this.history.window(this.keys);
    this.chart.setData(data as uPlot.AlignedData);
  }

  private drop(key: string): void {
    this.keys = this.keys.filter((one) => one !== key);
    this.rebuild();
    this.changed();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.area;
    if (width > 0 && height > 0) this.chart?.setSize({ width, height });
  }

  private rebuild(): void {
    this.chips.replaceChildren(
      ...this.keys.map((key, index) => {
        const { name = key, unit = "" } = this.history.find(key) ?? {};
        const words = [el("i", { class: "swatch" }), name, el("span", { class: "dim" }, unit), "×"];
        const chip = plainButton({ class: "chip", title: `Take ${key} out` }, () => this.drop(key), ...words);
        chip.style.setProperty("--colour", this.colour(index));
        return chip;
      }),
    );
    if (this.keys.length === 0) this.chips.append(el("span", { class: "dim" }, "Click a signal, or drag it here"));
    this.chart?.destroy();
    const lines = this.keys.map((_, index) => ({ ...LINE, stroke: this.colour(index) }));
    const options: uPlot.Options = {
      width: Math.max(this.area.clientWidth, 100),
      height: Math.max(this.area.clientHeight, 60),
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false } },
      scales: { x: { time: false } },
      axes: [
        { ...AXIS, size: 30, values: ticks("s") },
        {
          ...AXIS,
          size: (_, labels) => {
            this.labels = labels ?? [];
            return widest(this.labels);
          },
          values: ticks(),
        },
      ],
      hooks: { draw: [(chart) => this.drawCursor(chart)], ready: [(chart) => this.listen(chart)] },
      series: [{}, ...lines],
    };
    this.chart = new uPlot(options, this.history.window(this.keys) as uPlot.AlignedData, this.area);
  }

  /** The colour of the object that the line is about, or one of its own. */
  private colour(index: number): string {
    return this.history.find(this.keys[index] ?? "")?.colour ?? COLOURS[index] ?? AXIS.stroke;
  }

  /** The moment of the past that is looked at. */
  private drawCursor(chart: uPlot): void {
    const { cursor } = this.history;
    if (cursor === null) return;
    const { ctx, bbox } = chart;
    const x = chart.valToPos(cursor, "x", true);
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.save();
    ctx.strokeStyle = CURSOR;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  }

  /** A click looks at that moment. */
  private listen(chart: uPlot): void {
    chart.over.title = "Click to look at this moment";
    chart.over.addEventListener("click", (event) => {
      this.seek(chart.posToVal(event.offsetX, "x"));
    });
  }
}

/** Room for the longest label of an axis (pixels). */
function widest(labels: string[]): number {
  const longest = Math.max(0, ...labels.map((label) => label.length));
  return Math.max(46, 14 + 6 * longest);
}

/** Makes `node` a thing that carries signal `key` into a plot. */
export function draggable(node: HTMLElement, key: string): void {
  node.draggable = true;
  node.addEventListener("dragstart", (event) => {
    event.dataTransfer?.setData(TYPE, key);
    if (event.dataTransfer !== null) event.dataTransfer.effectAllowed = "copy";
  });
}
