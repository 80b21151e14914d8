// What lasted from when to when, below the bar: task, phases, grips, processes.
import type { Span } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr, setText, setTitle } from "../dom";
import { words } from "../format";
import { phaseColour } from "../phase-colour";
import { fits, fitted, ownParts } from "./short";
import type { TimeSpan } from "./zoom";

/** A narrower span is drawn this wide, but not beside another one of these (px). */
const TINY_PX = 3;
/** Until the width of the lanes is known (px). */
const USUAL_PX = 1000;
const KEY = "robocell.lanes";
/** So many lanes have room; more are lower, of which so many have room. */
const HIGH_LANES = 5;
const LOW_LANES = 6;
/** Height of a low lane with its margin (px). */
const LOW_PX = 14;
/** Width of the space beside a label (px). */
const BESIDE_PX = 6;

export interface Lanes {
  readonly root: HTMLElement;
  readonly fold: HTMLElement;
  /** How many spans are drawn. */
  readonly count: number;
  /** Draws the lanes of `window`, with the moment that is shown. */
  draw(window: TimeSpan, now_s: number): void;
}

interface Texts {
  /** Is added to what lasts until the end of the cell. */
  end: string;
  /** What tells the objects apart, by their names. */
  parts: Map<string, string>;
  /** Whether an object of the lane has no room for its whole name: all are spelled alike. */
  isShort: boolean;
  /** Width of the lanes (px). */
  width: number;
}

interface Drawn {
  span: Span;
  to_s: number;
  /** It has no room for its length. */
  isTiny: boolean;
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
  const inner = el("div", { class: "lane-area" }, tracks, cursor);
  const area = el("div", { class: "lanes", title: "Click to look at a moment" }, inner);
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
  let open = (localStorage.getItem(KEY) ?? (innerHeight >= 800 && innerWidth >= 1100 ? "open" : "folded")) === "open";
  const show = () => {
    root.hidden = !open || store.lanes.length === 0;
    setAttr(fold, "aria-expanded", String(open));
  };
  const toggle = () => {
    open = !open;
    localStorage.setItem(KEY, open ? "open" : "folded");
    show();
    changed();
  };
  const attrs = { class: "button small quiet lanes-button", title: "Phases, grips and processes over time" };
  const fold = plainButton(attrs, toggle, "Lanes");
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
      const texts = { end, parts, isShort: false, width: width > 0 ? width : USUAL_PX };
      const shown = lanes.filter((lane) => drawLane(lane, window, texts) || isAlwaysShown(lane.name));
      if (count !== shown.length) {
        count = shown.length;
        tellMore();
      }
      const rows = shown.map(({ row }) => row);
      if (rows.length !== tracks.childElementCount || rows.some((row, index) => tracks.children[index] !== row))
        tracks.replaceChildren(...rows);
      cursor.hidden = now_s < window.first || now_s > window.last;
      cursor.style.left = `${place(now_s, window)}%`;
    },
  };
}

/** The lanes of `all`, in the order in which they were told first; what was drawn is kept. */
function sorted(all: Span[], before: Lane[]): Lane[] {
  const order = ["task", "phase", "grip", "process", "recording"];
  const kinds = new Map(all.map((span) => [span.lane, span.kind]));
  const rank = (name: string) => order.indexOf(kinds.get(name) ?? "");
  const names = [...kinds.keys()].sort((one, other) => rank(one) - rank(other));
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
function drawLane({ spans, row, nodes }: Lane, window: TimeSpan, texts: Texts): boolean {
  let any = false;
  /** Where the last tiny span is (px). */
  let tiny_px = -Infinity;
  const scale = texts.width / (window.last - window.first);
  const isShort = isShortLane(spans, window, texts);
  for (const [index, span] of spans.entries()) {
    const next = spans[index + 1]?.from_s;
    const to_s = Math.max(next ?? window.last, span.from_s);
    const isSeen = span.label !== "" && to_s > window.first && span.from_s < window.last;
    any ||= isSeen;
    const from_px = (Math.max(span.from_s, window.first) - window.first) * scale;
    const isTiny = (Math.min(to_s, window.last) - window.first) * scale - from_px < TINY_PX;
    // One that tells of a failure is never left out.
    const isDrawn = isSeen && (!isTiny || span.tone === "bad" || from_px - tiny_px >= TINY_PX);
    if (!isDrawn) {
      nodes.get(span)?.remove();
      nodes.delete(span);
      continue;
    }
    if (isTiny) tiny_px = from_px;
    const known = nodes.get(span);
    const end = next === undefined ? texts.end : "";
    const node = bar(known, { span, to_s, isTiny }, window, { ...texts, isShort, end });
    if (known !== undefined) continue;
    nodes.set(span, node);
    row.insertBefore(node, row.lastElementChild);
  }
  return any;
}

/** Whether a span has room for the short name of its object only; the last one, which grows, does not change the others. */
function isShortLane(spans: Span[], { first, last }: TimeSpan, texts: Texts): boolean {
  const scale = texts.width / (last - first);
  return spans.slice(0, -1).some((span, index) => {
    if (span.kind !== "grip" || span.label === "") return false;
    const room = (Math.min(spans[index + 1]?.from_s ?? last, last) - Math.max(span.from_s, first)) * scale - BESIDE_PX;
    const shorter = labels(span, { ...texts, isShort: true })[0] ?? "";
    return fits(shorter, room) && !fits(span.label, room);
  });
}

/** A span as it is now, in `known` where it was drawn before. */
function bar(known: HTMLElement | undefined, drawn: Drawn, window: TimeSpan, texts: Texts): HTMLElement {
  const { span, to_s, isTiny } = drawn;
  const from = Math.max(span.from_s, window.first);
  const to = Math.min(to_s, window.last);
  const share = Math.max(to - from, 0) / (window.last - window.first);
  const node = known ?? el("i", { "data-kind": span.kind, "data-tone": span.tone });
  const colour = span.kind === "phase" ? phaseColour(span.label) : "";
  if (node.dataset.colour !== colour) {
    node.dataset.colour = colour;
    node.style.setProperty("--phase", colour);
  }
  const names = labels(span, texts);
  const time = `${span.from_s.toFixed(2)} s to ${to_s.toFixed(2)} s (${(to_s - span.from_s).toFixed(2)} s)`;
  setTitle(node, `${span.kind === "task" ? names[0] : span.label}\n${time}`);
  const text = isTiny ? "" : fitted(names, share * texts.width - BESIDE_PX);
  node.classList.toggle("tiny", isTiny);
  node.classList.toggle("blank", text === "");
  const left = `${place(from, window)}%`;
  node.style.left = isTiny ? `min(${left}, 100% - ${TINY_PX}px)` : left;
  node.style.width = `${100 * share}%`;
  setText(node, text);
  return node;
}

/** Texts of a span, the longest one first. */
function labels(span: Span, { end, parts, isShort }: Texts): string[] {
  const name = words(span.label);
  // As the object is spelled everywhere.
  const short = (parts.get(name) ?? name).replaceAll(" ", "_");
  if (span.kind === "grip") return isShort ? [short] : [span.label, short];
  if (span.kind !== "task" || end === "") return [name];
  return span.label === "running" ? [`${name}${end}`, `was ${name}`] : [`${name}${end}`, name];
}
