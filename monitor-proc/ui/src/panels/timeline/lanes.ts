// What lasted from when to when, below the bar: task, phases, grips, processes.
import type { Span } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { words } from "../format";
import { phaseColour } from "../phase-colour";
import { ownParts, shortened } from "./short";
import type { TimeSpan } from "./zoom";

/** Narrower spans are not drawn (share of the width). */
const LEAST_SHARE = 0.0008;
/** Wider ones have room for their label. */
const LABEL_SHARE = 0.03;
const KEY = "robocell.lanes";
/** So many lanes have room; more are lower, of which so many have room. */
const HIGH_LANES = 5;
const LOW_LANES = 6;
/** Height of a low lane with its margin (px). */
const LOW_PX = 14;
/** Width of a letter of a label, and of what is beside it (px). */
const LETTER_PX = 6;
const BESIDE_PX = 6;

export interface Lanes {
  readonly root: HTMLElement;
  readonly fold: HTMLElement;
  /** How many spans are drawn. */
  readonly count: number;
  /** Draws the lanes of `window`, with the moment that is shown. */
  draw(window: TimeSpan, now_s: number): void;
}

/** The text of a span that is named `name` and has this share of the width. */
type Label = (span: Span, name: string, share: number) => string;

interface Texts {
  /** Is added to what lasts until the end of the cell. */
  end: string;
  label: Label;
}

interface Drawn {
  span: Span;
  to_s: number;
}

interface Lane {
  name: string;
  spans: Span[];
  row: HTMLElement;
  /** By span, as it was told. */
  nodes: Map<Span, HTMLElement>;
}

export function mountLanes(context: PanelContext, changed: () => void): Lanes {
  const { store } = context;
  const cursor = el("i", { class: "lane-cursor" });
  const tracks = el("div", {});
  const area = el("div", { class: "lanes", title: "Click to look at a moment" }, el("div", { class: "lane-area" }, tracks, cursor));
  // As wide as the bar above, whatever room a scroll bar takes.
  const more = el("span", { class: "lanes-more", hidden: true });
  const root = el("div", { class: "lanes-place" }, area, more);
  let count = 0;
  let above = 0;
  const tellMore = () => {
    const below = count > HIGH_LANES ? count - LOW_LANES - above : 0;
    area.classList.toggle("low", count > HIGH_LANES);
    more.hidden = below <= 0;
    setText(more, `▾ ${below} more`);
  };
  area.addEventListener("scroll", () => {
    above = Math.round(area.scrollTop / LOW_PX);
    tellMore();
  });
  let width = 0;
  new ResizeObserver(() => {
    width = tracks.clientWidth;
  }).observe(tracks);
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
    changed();
  });
  let lanes: Lane[] = [];
  let known: Span[] | null = null;
  const sort = () => {
    if (store.spans === known) return;
    known = store.spans;
    lanes = sorted(store.spans, lanes);
  };
  store.on("lanes", show);
  store.on("hello", show);
  show();
  return {
    root,
    fold,
    get count() {
      return lanes.reduce((sum, { nodes }) => sum + nodes.size, 0);
    },
    draw(window, now_s) {
      if (root.hidden) return;
      sort();
      const isOver = context.link === "ended" || context.link === "refused";
      const end = isOver ? " when it ended" : "";
      const parts = ownParts(store.scene?.objects.map(({ name }) => words(name)) ?? []);
      const label: Label = (span, name, share) => {
        const letters = (share * width - BESIDE_PX) / LETTER_PX;
        // As the object is spelled everywhere.
        if (span.kind === "grip") return shortened(span.label, (parts.get(name) ?? name).replaceAll(" ", "_"), letters);
        return share > LABEL_SHARE ? name : "";
      };
      const shown = lanes.filter((lane) => drawLane(lane, window, { end, label }) || isAlwaysShown(lane.name));
      if (count !== shown.length) {
        count = shown.length;
        tellMore();
      }
      const rows = shown.map(({ row }) => row);
      if (rows.length !== tracks.childElementCount || rows.some((row, index) => tracks.children[index] !== row)) tracks.replaceChildren(...rows);
      cursor.hidden = now_s < window.first || now_s > window.last;
      cursor.style.left = `${place(now_s, window)}%`;
    },
  };
}

/** The lanes of `all`, in the order in which they were told first; what was drawn is kept. */
function sorted(all: Span[], before: Lane[]): Lane[] {
  const order = ["task", "phase", "grip", "process", "recording"];
  const kinds = new Map(all.map((span) => [span.lane, span.kind]));
  const names = [...kinds.keys()].sort((one, other) => order.indexOf(kinds.get(one) ?? "") - order.indexOf(kinds.get(other) ?? ""));
  return names.map((name) => {
    const spans = all.filter((span) => span.lane === name);
    const old = before.find((lane) => lane.name === name);
    const row = old?.row ?? el("div", { class: "lane", "data-lane": name }, el("span", { class: "lane-name" }, name));
    const kept = new Set(spans);
    for (const [span, node] of old?.nodes ?? []) {
      if (kept.has(span)) continue;
      node.remove();
      old?.nodes.delete(span);
    }
    return { name, spans, row, nodes: old?.nodes ?? new Map() };
  });
}

function isAlwaysShown(lane: string): boolean {
  return lane === "outcome" || lane.startsWith("phase");
}

/** Where `time_s` is (%). */
function place(time_s: number, { first, last }: TimeSpan): number {
  return (100 * (time_s - first)) / (last - first);
}

/** Draws the spans of a lane that are in `window`; whether there is one. */
function drawLane({ spans, row, nodes }: Lane, window: TimeSpan, { end, label }: Texts): boolean {
  let any = false;
  for (const [index, span] of spans.entries()) {
    const next = spans[index + 1]?.from_s;
    const to_s = Math.max(next ?? window.last, span.from_s);
    const isSeen = span.label !== "" && to_s > window.first && span.from_s < window.last;
    any ||= isSeen;
    const node = isSeen ? bar(nodes.get(span), { span, to_s }, window, { end: next === undefined ? end : "", label }) : null;
    if (node === null) {
      nodes.get(span)?.remove();
      nodes.delete(span);
    } else if (!nodes.has(span)) {
      nodes.set(span, node);
      row.insertBefore(node, row.lastElementChild);
    }
  }
  return any;
}

/** A span as it is now, in `known` where it was drawn before. */
function bar(known: HTMLElement | undefined, { span, to_s }: Drawn, window: TimeSpan, { end, label }: Texts): HTMLElement | null {
  const from = Math.max(span.from_s, window.first);
  const to = Math.min(to_s, window.last);
  const share = (to - from) / (window.last - window.first);
  // A process that was down for a moment is to be seen.
  if (share < LEAST_SHARE && span.kind !== "process") return null;
  const node = known ?? el("i", { "data-kind": span.kind, "data-tone": span.tone });
  const colour = span.kind === "phase" ? phaseColour(span.label) : "";
  if (node.dataset.colour !== colour) {
    node.dataset.colour = colour;
    node.style.setProperty("--phase", colour);
  }
  const name = span.kind === "task" && end !== "" ? `${span.label}${end}` : span.label;
  setTitle(node, `${name}\n${span.from_s.toFixed(2)} s to ${to_s.toFixed(2)} s (${(to_s - span.from_s).toFixed(2)} s)`);
  node.style.left = `${place(from, window)}%`;
  node.style.width = `${Math.max(100 * share, 0.15)}%`;
  setText(node, label(span, words(name), share));
  return node;
}
