// What lasted from when to when, below the bar: task, phases, grips, processes.
import type { Span } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, setAttr } from "../dom";
import { words } from "../format";
import { phaseHue } from "../phase-hue";

/** Narrower spans are not drawn (share of the width). */
const LEAST_SHARE = 0.0008;
/** Wider ones have room for their label. */
const LABEL_SHARE = 0.03;
const REDRAW_MS = 500;
const KEY = "robocell.lanes";

export interface Lanes {
  readonly root: HTMLElement;
  readonly fold: HTMLElement;
}

interface Drawn {
  span: Span;
  to_s: number;
}

export function mountLanes(context: PanelContext, window: () => { first: number; last: number }): Lanes {
  const { store } = context;
  const cursor = el("i", { class: "lane-cursor" });
  const tracks = el("div", {});
  const root = el("div", { class: "lanes", title: "Click to look at a moment" }, el("div", { class: "lane-area" }, tracks, cursor));
  const fold = el("button", { type: "button", class: "button small quiet lanes-button", title: "Phases, grips and processes over time" }, "Lanes");
  let open = (localStorage.getItem(KEY) ?? (innerHeight >= 800 && innerWidth >= 1100 ? "open" : "folded")) === "open";
  const show = () => {
    root.hidden = !open || store.lanes.length === 0;
    setAttr(fold, "aria-expanded", String(open));
  };
  fold.addEventListener("click", () => {
    open = !open;
    localStorage.setItem(KEY, open ? "open" : "folded");
    show();
    draw();
  });
  const draw = () => {
    if (root.hidden) return;
    const { first, last } = window();
    const rows = laneNames(store.lanes).map((name) => {
      const spans = drawn(store.lanes.filter((span) => span.lane === name && store.isCurrent({ epoch: span.epoch, time_s: span.from_s })), last);
      const bars = spans.filter(({ span, to_s }) => span.label !== "" && to_s > first && span.from_s < last);
      return { name, bars };
    });
    const nodes = rows.filter(({ name, bars }) => bars.length > 0 || isAlwaysShown(name)).map(({ name, bars }) => {
      const children = bars.map((one) => bar(one, first, last)).filter((node) => node !== null);
      return el("div", { class: "lane", "data-lane": name }, ...children, el("span", { class: "lane-name" }, name));
    });
    tracks.replaceChildren(...nodes);
  };
  let drawnAt = 0;
  context.pulse.add(root, () => {
    const { first, last } = window();
    const time = store.snapshot?.time ?? 0;
    cursor.style.left = `${(100 * (time - first)) / (last - first)}%`;
    const now = performance.now();
    if (now - drawnAt < REDRAW_MS) return;
    drawnAt = now;
    draw();
  });
  store.on("lanes", show);
  store.on("hello", show);
  show();
  return { root, fold };
}

/** Lanes in the order in which they were told first. */
function laneNames(spans: Span[]): string[] {
  const order = ["task", "phase", "grip", "process", "recording"];
  const kinds = new Map(spans.map((span) => [span.lane, span.kind]));
  return [...kinds.keys()].sort((one, other) => order.indexOf(kinds.get(one) ?? "") - order.indexOf(kinds.get(other) ?? ""));
}

function isAlwaysShown(lane: string): boolean {
  return lane === "outcome" || lane.startsWith("phase");
}

/** Each span with its end. */
function drawn(spans: Span[], last: number): Drawn[] {
  return spans.map((span, index) => ({ span, to_s: Math.max(spans[index + 1]?.from_s ?? last, span.from_s) }));
}

function bar({ span, to_s }: Drawn, first: number, last: number): HTMLElement | null {
  const from = Math.max(span.from_s, first);
  const share = (Math.min(to_s, last) - from) / (last - first);
  // A process that was down for a moment is to be seen.
  if (share < LEAST_SHARE && span.kind !== "process") return null;
  const length = `${(to_s - span.from_s).toFixed(2)} s`;
  const node = el("i", { "data-kind": span.kind, "data-tone": span.tone, title: `${span.label}\n${span.from_s.toFixed(2)} s to ${to_s.toFixed(2)} s (${length})` });
  node.style.left = `${(100 * (from - first)) / (last - first)}%`;
  node.style.width = `${Math.max(100 * share, 0.15)}%`;
  if (span.kind === "phase") node.style.setProperty("--hue", String(phaseHue(span.label)));
  if (share > LABEL_SHARE) node.textContent = words(span.label);
  return node;
}
