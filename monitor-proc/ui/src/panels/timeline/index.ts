// What the flight recorder holds, with marks for what happened; dragging looks
// back.
import { FLAG } from "../../net/snapshot";
import { button, setIcon } from "../button";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr, setText } from "../dom";
import { sentence, tenths } from "../format";
import { episodes } from "./episodes";
import { mountLanes } from "./lanes";
import { linkButton } from "./link-button";
import { drawnMarks } from "./marks";
import { playback } from "./playback";
import { seeker } from "./seeker";
import { Zoom } from "./zoom";

/** A mark nearer than this to the moment shown is this moment (s). */
const SAME_MOMENT_S = 0.02;

/** More spans are drawn less often. */
const MANY_SPANS = 300;
const REDRAW_MS = 500;

const MARKS: [string, string][] = [
  ["drop", "object lost"],
  ["break", "grip lost"],
  ["resync", "picked up again"],
  ["abort", "turned back"],
  ["recover", "recovery"],
  ["restart", "process restarted"],
  ["reset", "task reset"],
  ["hand", "by an operator"],
  ["hand_failed", "failed by hand"],
  ["done", "done"],
  ["part", "one arm is done"],
  ["fault", "failure"],
  ["incident", "incident (click)"],
];

export function mountTimeline(context: PanelContext, host: HTMLElement): void {
  const { store } = context;
  const marks = el("div", { class: "marks" });
  const cursor = el("i", { class: "cursor" });
  const about =
    "Drag to look back; Shift and drag to choose a range that is looped; the wheel zooms, with Shift it moves";
  const attrs = { class: "bar", role: "slider", tabindex: 0, "aria-label": "Time shown", title: about };
  const bar = el("div", attrs, cursor);
  // Marks can be pressed, and a slider has nothing in it that can.
  const track = el("div", { class: "time-track" }, bar, marks);
  const from = el("span", { class: "num dim" });
  const to = el("span", { class: "num dim" });
  const now = el("output", { class: "num now" });
  const zoom = new Zoom();
  const recorded = () => {
    const { timeline, snapshot } = store;
    const end = snapshot?.time ?? 0;
    // The last state of a recording may be later than the end that is told.
    const past = context.flag(FLAG.notLive) && store.hello?.live !== false;
    const first = timeline?.from_s ?? Math.min(end, 0);
    return { first, last: Math.max(timeline?.to_s ?? 0, past ? 0 : end, first + 0.001) };
  };
  // One window for bar, marks and lanes: each would else have the time at which it was drawn.
  let window = zoom.of(recorded());
  const span = () => window;
  const share = (time: number) => {
    const { first, last } = span();
    return Math.min(Math.max((time - first) / (last - first), 0), 1);
  };
  const seek = seeker(context);
  const timeAt = (x: number) => {
    const box = bar.getBoundingClientRect();
    const { first, last } = span();
    return first + Math.min(Math.max((x - box.left) / box.width, 0), 1) * (last - first);
  };
  const play = playback(context, seek);
  const range = el("i", { class: "range" });
  bar.append(range);
  let rangeFrom: number | null = null;
  const hand = (event: PointerEvent) => {
    const time = timeAt(event.clientX);
    if (rangeFrom !== null) play.setRange(rangeFrom, time);
    else play.seek(time);
  };
  const listen = (node: HTMLElement) => {
    node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      node.setPointerCapture(event.pointerId);
      rangeFrom = event.shiftKey ? timeAt(event.clientX) : null;
      hand(event);
    });
    node.addEventListener("pointermove", (event) => {
      if (node.hasPointerCapture(event.pointerId)) hand(event);
    });
  };
  listen(track);
  const turn = (event: WheelEvent) => {
    // The lanes scroll where the wheel is over them.
    if (!(event.target instanceof Node) || !track.contains(event.target)) return;
    event.preventDefault();
    zoom.wheel(event.deltaY || event.deltaX, event.shiftKey || event.deltaY === 0, timeAt(event.clientX), recorded());
    draw();
  };
  host.addEventListener("wheel", turn, { passive: false });
  const showAll = () => {
    zoom.all();
    draw();
  };
  const whole = plainButton({ class: "button small quiet", title: "Show all recorded time again" }, showAll, "All");
  context.toMark = (direction) => {
    const at = store.snapshot?.time ?? 0;
    const { first, last } = recorded();
    const marked = store.marked.filter((line) => line.mark !== null && store.isCurrent(line));
    const times = marked.map(({ time_s }) => time_s);
    const beyond = times.filter((time) => time >= first && time <= last && direction * (time - at) > SAME_MOMENT_S);
    if (beyond.length === 0) return context.notify(`no ${direction > 0 ? "later" : "earlier"} mark`);
    play.seek(direction > 0 ? Math.min(...beyond) : Math.max(...beyond));
  };
  bar.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -0.1, ArrowRight: 0.1, PageUp: -5, PageDown: 5 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const { first, last } = span();
    const wanted = (store.snapshot?.time ?? last) + (event.shiftKey ? 10 * step : step);
    play.seek(Math.min(Math.max(wanted, first), last));
  });

  const drawMarks = drawnMarks(context, marks, span);
  const show = () => {
    const time = store.snapshot?.time ?? 0;
    const { first, last } = span();
    cursor.style.left = `${100 * share(time)}%`;
    cursor.hidden = time < first || time > last;
    whole.hidden = !zoom.isZoomed;
    range.hidden = play.range === null;
    if (play.range !== null) {
      range.style.left = `${100 * share(play.range[0])}%`;
      range.style.width = `${100 * (share(play.range[1]) - share(play.range[0]))}%`;
    }
    setText(from, tenths(first));
    setText(to, tenths(last));
    setText(now, shownTime(context, time, last));
    setAttr(bar, "aria-valuemin", first.toFixed(2));
    setAttr(bar, "aria-valuemax", last.toFixed(2));
    setAttr(bar, "aria-valuenow", time.toFixed(2));
  };
  const lanes = mountLanes(context, () => draw());
  const draw = () => {
    window = zoom.of(recorded());
    show();
    drawMarks();
    lanes.draw(window, store.snapshot?.time ?? 0);
  };
  store.on("log", drawMarks);
  let drawnAt = -Infinity;
  context.pulse.add(host, () => {
    const now = performance.now();
    if (lanes.count > MANY_SPANS && now - drawnAt < REDRAW_MS) return;
    drawnAt = now;
    draw();
  });
  const legend = MARKS.map(([mark, about]) => {
    return { mark, node: el("span", { hidden: true }, el("i", { "data-mark": mark }), about) };
  });
  // Only marks that are drawn: one line has no room for all.
  context.pulse.add(host, () => {
    const drawn = new Set([...marks.querySelectorAll<HTMLElement>("[data-mark]")].map(({ dataset }) => dataset.mark));
    for (const { mark, node } of legend) node.hidden = !drawn.has(mark);
  });
  listen(lanes.root);
  const toNow = liveButton(context, () => play.seek(null));
  const live = el("div", { class: "row" }, toNow, lanes.fold, linkButton(context), whole);
  host.replaceChildren(
    live,
    now,
    from,
    track,
    to,
    play.root,
    episodes(context),
    lanes.root,
    el("div", { class: "legend dim" }, ...legend.map(({ node }) => node)),
  );
  // Of a recording only the loop is left of it.
  store.on("hello", (hello) => (hello.live ? to.after(play.root) : live.append(play.root)));
  draw();
}

function shownTime(context: PanelContext, time: number, last: number): string {
  if (!context.flag(FLAG.notLive) || context.store.hello?.live === false) return `${time.toFixed(2)} s`;
  const { past, timeline } = context.store;
  const newest = timeline?.epochs.at(-1)?.epoch;
  // What came after the time that physics resumed at.
  if (past?.epoch != null && past.epoch !== newest) return `${time.toFixed(2)} s (before physics restarted)`;
  return `${time.toFixed(2)} s (${(time - last).toFixed(1)} s)`;
}

/** Back to now; in a recording, play and pause. */
function liveButton(context: PanelContext, toNow: () => void): HTMLElement {
  const replay = () => context.store.hello?.live === false;
  const away = () => context.flag(FLAG.notLive) && !replay();
  const isOver = () => context.link === "ended" || context.link === "refused";
  const node = button(context, {
    icon: "dot",
    label: "Live",
    class: "live",
    about: () => {
      if (replay()) return context.paused ? "Play the recording" : "Pause the recording";
      if (away()) return "Back to the present";
      return `You see the present${context.paused ? ", and the clock is paused" : ""}; drag along the bar to look back`;
    },
    twin: () => (replay() ? "robocell replay FILE" : null),
    why: () => (isOver() ? "nothing comes any more" : null),
    run: () => {
      // Not around the playback: its next step would lead back into the past.
      if (!replay()) return toNow();
      const time = context.snapshot?.time ?? 0;
      return context.send({ do: "seek", time_s: time, play: context.paused });
    },
  });
  const name = node.querySelector("span");
  context.pulse.add(node, () => {
    if (context.link !== "connected" && name !== null) {
      setText(name, sentence(context.link));
      setIcon(node, isOver() ? "stop" : "dot");
      setAttr(node, "data-tone", null);
      return;
    }
    // The present of a clock that is paused is not live.
    const still = context.paused && !away();
    if (name !== null)
      setText(name, replay() ? (still ? "Play" : "Pause") : away() ? "Back to live" : still ? "Paused" : "Live");
    setIcon(node, replay() ? (still ? "play" : "pause") : still ? "pause" : "dot");
    const tone = replay() ? "info" : away() ? "warn" : still ? "still" : "ok";
    setAttr(node, "data-tone", tone);
  });
  return node;
}
