// Marks on the bar for what happened; one of incidents opens them.
import type { LogLine } from "../../net/protocol";
import { lasting } from "../../net/wrong";
import type { PanelContext } from "../context";
import { el } from "../dom";
import { openIncident } from "../incident/index";
import { movedApart, type Place } from "./apart";
import type { TimeSpan } from "./zoom";

/** Incidents closer than this have one mark, so that each can be pressed (pixels). */
const APART_PX = 24;

const SAME_END_S = 0.2;
/** Widths with a gap (pixels). */
const MARK_PX = 13;
const BEFORE_PX = 26;
const INCIDENT_PX = 21;
/** What an operator or the task did; the others tell how the task ended, and what went wrong. */
const QUIET = new Set(["hand", "reset", "resync", "abort", "recover", "part"]);

/** A line and where it is marked. */
interface Seen {
  line: LogLine;
  at_s: number;
  /** It is earlier, and lasts. */
  isBefore?: boolean;
}

interface Mark {
  /** The same mark keeps its node, so that a node is not replaced while it is pressed. */
  key: string;
  time_s: number;
  width_px: number;
  isQuiet: boolean;
  make: () => HTMLElement;
}

/** Draws the marks of the log into `host`; to be called when they may have changed. */
export function drawnMarks(context: PanelContext, host: HTMLElement, span: () => TimeSpan): () => void {
  const { store } = context;
  // To ask for it in each picture costs a layout of the page.
  let width = 1;
  new ResizeObserver(() => {
    width = Math.max(host.clientWidth, 1);
  }).observe(host);
  let nodes = new Map<string, HTMLElement>();
  return () => {
    const { first, last } = span();
    const isFailure = (line: LogLine) => line.incident !== undefined || line.mark === "restart";
    const at = (line: LogLine) => (isFailure(line) ? store.markedAt(line) : line.time_s);
    const fits = (line: LogLine) => at(line) >= first && at(line) <= last && (isFailure(line) || store.isCurrent(line));
    const ends = store.marked.filter(({ mark }) => mark === "done");
    // The last arm and the task end in one moment, which has one mark.
    const isEnd = ({ mark, time_s }: LogLine) =>
      mark === "part" && ends.some((end) => Math.abs(end.time_s - time_s) < SAME_END_S);
    const fitting = store.marked.filter((line) => line.mark !== null && fits(line) && !isEnd(line));
    const seen: Seen[] = fitting.map((line) => ({ line, at_s: at(line) }));
    // A lasting state is marked at the start of the window.
    const before = lasting(store).filter((line) => line.incident === undefined && at(line) < first);
    seen.push(...before.map((line) => ({ line, at_s: first, isBefore: true })));
    const hasIncident = seen.some(({ line }) => line.incident !== undefined);
    const apart_s = hasIncident ? (APART_PX / width) * (last - first) : 0;
    const others = seen.filter(({ line }) => line.incident === undefined);
    const marks = [...others.map(plain), ...incidents(context, seen, apart_s)];
    const shown = new Map(marks.map((mark) => [mark.key, nodes.get(mark.key) ?? mark.make()]));
    place(marks, shown, (time_s) => (time_s - first) / (last - first), width);
    const isSame = shown.size === nodes.size && [...shown.keys()].every((key) => nodes.has(key));
    if (!isSame) replace(host, nodes, shown);
    nodes = shown;
  };
}

/** Puts each where its time is, and those that would cover each other apart. */
function place(marks: Mark[], nodes: Map<string, HTMLElement>, share: (time_s: number) => number, width: number): void {
  // Equal ones have one node.
  const all = [...new Map(marks.map((mark) => [mark.key, mark])).values()];
  const places = new Map(all.map((mark): [Place, Mark] => [{ ...mark, at_px: share(mark.time_s) * width }, mark]));
  const moved = width > 1 ? movedApart([...places.keys()], width) : new Map<Place, number>();
  for (const [at, { key, time_s }] of places) {
    const [percent, px] = [(100 * share(time_s)).toFixed(3), (moved.get(at) ?? 0).toFixed(1)];
    nodes.get(key)?.style.setProperty("--at", `calc(${percent}% + ${px}px)`);
  }
}

/** Leaves the nodes that stay where they are: they may have the focus. */
function replace(host: HTMLElement, before: Map<string, HTMLElement>, after: Map<string, HTMLElement>): void {
  for (const [key, node] of before) if (!after.has(key)) node.remove();
  let next: HTMLElement | null = null;
  for (const node of [...after.values()].reverse()) {
    if (node.parentNode !== host || node.nextSibling !== next) host.insertBefore(node, next);
    next = node;
  }
}

function plain({ line, at_s, isBefore = false }: Seen): Mark {
  const title = isBefore ? `${told(line)}\nearlier than the bar begins; it lasts` : told(line);
  const isQuiet = QUIET.has(line.mark ?? "");
  const symbol = () => el("i", { "data-mark": line.mark ?? "", class: isQuiet ? "quiet" : false, title });
  return {
    key: `${line.mark} ${title}`,
    time_s: at_s,
    width_px: isBefore ? BEFORE_PX : MARK_PX,
    isQuiet: !isBefore && isQuiet,
    make: () => (isBefore ? el("span", { class: "before", title }, "‹", symbol()) : symbol()),
  };
}

/** Incidents, those of one moment together. */
function incidents(context: PanelContext, seen: Seen[], apart_s: number): Mark[] {
  const groups: Seen[][] = [];
  const found = seen.filter(({ line }) => line.incident !== undefined);
  for (const one of found.sort((a, b) => (a.line.incident ?? 0) - (b.line.incident ?? 0))) {
    const group = groups.find(([first]) => first !== undefined && Math.abs(first.at_s - one.at_s) < apart_s);
    if (group === undefined) groups.push([one]);
    else group.push(one);
  }
  return groups.map((group) => {
    const lines = group.map(({ line }) => line);
    // Failures within a second are one incident and may still be apart on the bar.
    const key = `incident ${lines.map(told).join(" ")}`;
    const make = () => opener(context, lines);
    return { key, time_s: group[0]?.at_s ?? 0, width_px: INCIDENT_PX, isQuiet: false, make };
  });
}

function opener(context: PanelContext, lines: LogLine[]): HTMLElement {
  const [title, label] = [lines.map(told).join("\n"), lines.map(({ text }) => text).join("; ")];
  const about = { "data-mark": "incident", title, "aria-label": label };
  const count = new Set(lines.map((line) => line.incident)).size;
  const node = el("button", { type: "button", ...about }, count > 1 ? `${count}` : "");
  // The bar under it would look back.
  node.addEventListener("pointerdown", (event) => event.stopPropagation());
  node.addEventListener("keydown", (event) => event.stopPropagation());
  const number = lines[0]?.incident;
  if (number !== undefined) node.addEventListener("click", () => void openIncident(context, number));
  return node;
}

function told(line: LogLine): string {
  return `${line.time_s.toFixed(2)} s  ${line.text}`;
}
