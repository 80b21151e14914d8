// Up to four plots and the signals to put into them. The URL keeps them.
import type { PanelContext } from "../context";
import { el, plainButton, setAttr, setText } from "../dom";
import { getHash, setHash } from "../hash";
import { History } from "./history";
import { draggable, Plot } from "./plot";

const MOST_PLOTS = 4;
const FIRST = "distance to target";
const MOST_HEIGHTS = 6;

export function plotsTab(context: PanelContext): HTMLElement {
  const history = new History(context.store);
  const stack = el("div", { class: "plot-stack" });
  const plots: Plot[] = [];
  let active: Plot | null = null;
  let held = false;

  const keep = () => setHash("plots", plots.map((plot) => plot.keys.join("~")).join("|") || null);
  const activate = (plot: Plot | null) => {
    active = plot;
    for (const one of plots) one.root.classList.toggle("active", one === plot);
  };
  const seek = (time_s: number) => {
    const epoch = context.store.past?.epoch ?? null;
    void context.send({ do: "seek", time_s: Math.max(0, time_s), ...(epoch === null ? {} : { epoch }) });
  };
  const add = (keys: string[]) => {
    if (plots.length >= MOST_PLOTS) return;
    const plot: Plot = new Plot(history, keys, keep, seek, () => {
      plots.splice(plots.indexOf(plot), 1);
      plot.root.remove();
      activate(plots[0] ?? null);
      keep();
    });
    plot.root.addEventListener("pointerdown", () => activate(plot));
    plot.root.addEventListener("focusin", () => activate(plot));
    plots.push(plot);
    stack.append(plot.root);
    activate(plot);
  };

  const list = signalList(history, (key) => {
    if (active === null) add([]);
    active?.add(key);
    keep();
  });
  const span = el("span", { class: "dim" });
  const more = plainButton({ class: "button small" }, () => add([]), "Add plot");
  const toggle = () => {
    held = !held;
    setText(hold, held ? "Continue" : "Hold");
    setAttr(hold, "aria-pressed", String(held));
  };
  const about = "Hold the picture; the signals continue behind it";
  const hold = plainButton({ class: "button small", title: about }, toggle, "Hold");

  let begun = false;
  const begin = () => {
    if (begun || history.signals.length === 0 || context.store.scene === null) return;
    begun = true;
    const kept = getHash("plots");
    const wanted = kept === null ? usual() : kept.split("|").map((one) => one.split("~").filter(Boolean));
    fill(wanted);
  };
  const fill = (wanted: string[][]) => {
    for (const keys of wanted.slice(0, MOST_PLOTS)) add(keys);
    activate(plots[0] ?? null);
  };
  const usual = (): string[][] => {
    const first = history.signals.find(({ name }) => name === FIRST)?.key;
    const heights = history.signals.filter(({ group }) => group === "objects").slice(0, MOST_HEIGHTS);
    const joints = history.signals.filter(({ name }) => name.endsWith("position")).slice(0, 7);
    const load = history.signals.filter(({ name }) => name === "suction load");
    const second = [load, heights, joints].find((one) => one.length > 0) ?? [];
    return [first === undefined ? [] : [first], second.map(({ key }) => key)];
  };
  // Another scene has other signals.
  let demo = context.store.scene?.demo;
  const follow = () => {
    const scene = context.store.scene;
    if (!begun || scene === null || scene.demo === demo) return begin();
    demo = scene.demo;
    const left = plots.filter((plot) => plot.prune());
    if (left.length === plots.length) return keep();
    for (const plot of plots.splice(0)) plot.root.remove();
    fill(left.length > 0 ? left.map(({ keys }) => keys) : usual());
    keep();
  };
  history.on(follow);
  begin();
  context.pulse.add(stack, () => {
    more.disabled = plots.length >= MOST_PLOTS;
    setText(span, history.cursor === null ? "last 30 s" : `30 s around ${history.cursor.toFixed(2)} s`);
    if (held) return;
    history.follow();
    for (const plot of plots) plot.show();
  });
  return el("div", { class: "plots-tab column" }, el("div", { class: "row" }, more, hold, span), stack, list);
}

function signalList(history: History, onPick: (key: string) => void): HTMLElement {
  const filter = el("input", { type: "search", placeholder: "find a signal", "aria-label": "Find a signal" });
  const body = el("div", { class: "signal-body scroll" });
  const fill = () => {
    const wanted = filter.value.trim().toLowerCase();
    const groups = new Map<string, HTMLElement[]>();
    for (const { key, group, name, unit } of history.signals) {
      if (!key.toLowerCase().includes(wanted)) continue;
      const attrs = { class: "signal", title: "Click, or drag it into a plot" };
      const node = plainButton(attrs, () => onPick(key), name, el("span", { class: "dim" }, unit));
      draggable(node, key);
      groups.set(group, [...(groups.get(group) ?? []), node]);
    }
    const open = wanted !== "";
    const parts = [...groups].map(([name, nodes], index) =>
      el("details", { open: open || index === 0 }, el("summary", {}, name), el("div", { class: "signals" }, ...nodes)),
    );
    body.replaceChildren(...parts);
  };
  filter.addEventListener("input", fill);
  history.on(fill);
  fill();
  return el("div", { class: "signal-list" }, filter, body);
}
