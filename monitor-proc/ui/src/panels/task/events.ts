// What was said, newest last, with a filter.
import type { LogLine } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr, setText } from "../dom";
import { lastScroll } from "../last-scroll";
import { addRow, showRow, timeOf } from "./event-row";

const SHOWN = 400;
/** What a line is about; the first three are told by the task. */
const KINDS = ["log", "transition", "task", "process", "operator"] as const;
/** Nearer to the end of the list is at its end. */
const AT_END_PX = 12;
/** A list continues to scroll for so long after a hand left it. */
const HAND_MS = 600;
/** Kinds that are not shown, kept over reloads. */
const KEY = "robocell.events.hidden";

function kindOf(line: LogLine): (typeof KINDS)[number] {
  if (/^(operator|by hand):/.test(line.text)) return "operator";
  if (line.mark === "incident" || line.text.startsWith("[cell]")) return "process";
  return line.kind === "lifecycle" ? "task" : line.kind;
}

export function eventLog(context: PanelContext): HTMLElement {
  const { store } = context;
  const list = el("div", { class: "event-list scroll", role: "log", tabindex: 0, "aria-label": "Events" });
  const filter = el("input", { type: "search", placeholder: "filter", "aria-label": "Filter events" });
  const unwanted = new Set((localStorage.getItem(KEY) ?? "").split(" "));
  const hidden = el("span", { class: "dim" });
  const empty = el("p", { class: "dim hint no-event" });
  const fits = (line: LogLine) =>
    !unwanted.has(kindOf(line)) && line.text.toLowerCase().includes(filter.value.trim().toLowerCase());

  // The newest line is in view, unless a person scrolled away from it.
  let follows = true;
  const follow = () => {
    if (follows && list.clientHeight > 0) toEnd(list);
  };
  let willFollow = false;
  /** Before the next picture: room below the newest line would show a part of the next one. */
  const followSoon = () => {
    if (willFollow) return;
    willFollow = true;
    requestAnimationFrame(() => {
      willFollow = false;
      follow();
    });
  };
  // Lines that come meanwhile, and the browser itself, scroll it too: only what follows a person's hand counts.
  const scrolledAt = lastScroll(list);
  list.addEventListener("scroll", () => {
    if (list.clientHeight === 0) return;
    const isAtEnd = list.scrollHeight - list.scrollTop - list.clientHeight < AT_END_PX;
    if (isAtEnd) follows = true;
    else if (performance.now() - scrolledAt() < HAND_MS) follows = false;
  });
  new ResizeObserver(follow).observe(list);
  list.addEventListener("keydown", (event) => moveFocus(list, event));
  /** A recording tells nothing before its clock, which is the time of the picture. */
  const replayed_s = () => (store.hello?.live === false ? (store.snapshot?.time ?? 0) : Infinity);
  const append = (lines: LogLine[]) => {
    const until_s = replayed_s();
    for (const line of lines.filter(fits).slice(-SHOWN)) {
      const node = addRow(context, list, line, kindOf(line));
      showRow(node, Math.min(until_s, shown));
      node.hidden = timeOf(node) > until_s;
    }
    while (list.childElementCount > SHOWN) list.firstElementChild?.remove();
    const left = store.log.length - store.log.filter(fits).length;
    setText(hidden, left === 0 ? "" : `${left} hidden`);
    setText(empty, list.childElementCount > 0 ? "" : left === 0 ? "No event yet." : "No event fits the filter.");
    empty.hidden = empty.textContent === "";
    followSoon();
  };
  // Shown with the clock: frames may be rare, and a line must not be later than the clock beside it.
  let waiting: LogLine[] = [];
  const fill = () => {
    waiting = [];
    list.replaceChildren();
    append(store.log);
  };
  const rebuild = () => {
    follows = true;
    fill();
  };
  filter.addEventListener("input", rebuild);
  const chips = KINDS.map((kind) => {
    const show = () => setAttr(chip, "aria-pressed", String(!unwanted.has(kind)));
    const toggle = () => {
      if (!unwanted.delete(kind)) unwanted.add(kind);
      localStorage.setItem(KEY, [...unwanted].join(" ").trim());
      show();
      rebuild();
    };
    const chip = plainButton({ class: "button small", title: `Show or hide ${kind} lines` }, toggle, kind);
    show();
    return chip;
  });
  store.on("hello", rebuild);
  context.pulse.add(list, () => {
    if (waiting.length === 0) return;
    append(waiting.splice(0));
    // In the picture that has the line.
    follow();
  });
  store.on("log", (lines) => {
    if (lines.length > 0) {
      waiting = [...waiting, ...lines].slice(-SHOWN);
      return;
    }
    // A line that came late is no reason to leave what a person reads.
    const { scrollTop } = list;
    fill();
    list.scrollTop = scrollTop;
  });
  // What comes after the moment that is shown is not said yet.
  let shown = Infinity;
  let followed = true;
  context.pulse.add(list, () => {
    const now = store.past === null ? replayed_s() : (store.snapshot?.time ?? Infinity);
    if (now === shown) return;
    if (shown === Infinity) followed = follows;
    shown = now;
    let last: Element | null = null;
    for (const node of list.children) {
      showRow(node, now);
      const isLater = timeOf(node) > now;
      if (store.hello?.live === false) (node as HTMLElement).hidden = isLater;
      else node.classList.toggle("later", isLater);
      if (!isLater) last = node;
    }
    if (now === Infinity) follows = followed;
    // The newest line of the moment that is shown is in view; later ones of a recording take no room.
    if (now !== Infinity && now !== replayed_s() && last !== null)
      list.scrollTop += last.getBoundingClientRect().bottom - list.getBoundingClientRect().bottom;
    else follow();
  });
  rebuild();
  return el("div", { class: "events" }, el("div", { class: "row event-bar" }, filter, ...chips, hidden), empty, list);
}

/** Scrolls to the newest line, so that the first one in sight is whole. */
function toEnd(list: HTMLElement): void {
  list.style.paddingBottom = "";
  list.scrollTop = list.scrollHeight;
  const { top } = list.getBoundingClientRect();
  let node = list.lastElementChild;
  while (node !== null && ((node as HTMLElement).hidden || node.getBoundingClientRect().top > top))
    node = node.previousElementSibling;
  const cut_px = node === null ? 0 : node.getBoundingClientRect().bottom - top;
  // One that fills the list is better cut than away.
  if (node === null || cut_px > list.clientHeight / 2 || top - node.getBoundingClientRect().top < 1) return;
  list.style.paddingBottom = `${Math.max(0, cut_px)}px`;
  list.scrollTop = list.scrollHeight;
}

/** One tab stop for all lines: the arrows go from one to the next. */
function moveFocus(list: HTMLElement, event: KeyboardEvent): void {
  const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
  if (step === undefined) return;
  const all = [...list.querySelectorAll<HTMLElement>("button")];
  const now = all.indexOf(document.activeElement as HTMLElement);
  const next = now < 0 ? all.at(-1) : all[now + step];
  if (next === undefined) return;
  event.preventDefault();
  next.focus();
}
