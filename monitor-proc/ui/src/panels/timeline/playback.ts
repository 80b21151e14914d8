// Plays the past of a live cell at any speed, and loops over a range.
import { FLAG } from "../../net/snapshot";
import { button, setIcon } from "../button";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr, setOptions, setText } from "../dom";
import type { Seek } from "./seeker";

const SPEEDS = ["0.1", "0.25", "0.5", "1", "2", "4", "10"];
/** A shorter range is a click (s). */
const LEAST_S = 0.1;
const FRAME_MS = 50;

export interface Playback {
  readonly root: HTMLElement;
  /** The span that is looped, in simulated seconds. */
  readonly range: [number, number] | null;
  setRange(from: number, to: number): void;
  /** Looks at a moment, null for now, and stays there. */
  seek(time: number | null): void;
}

export function playback(context: PanelContext, look: Seek): Playback {
  const { store } = context;
  let range: [number, number] | null = null;
  let loops = false;
  /** Simulated and wall-clock time of the last step, while it plays. */
  let at: { time: number; wall: number } | null = null;
  const speed = el("select", { "aria-label": "Speed of the past", title: "Simulated seconds of the past a second" });
  setOptions(speed, SPEEDS, "1");
  const isReplay = () => store.hello?.live === false;
  const end = () => (loops && range !== null ? range[1] : (store.timeline?.to_s ?? 0));
  const begin = () => (loops && range !== null ? range[0] : (store.timeline?.from_s ?? 0));
  /** A recording played until its end, where its clock pauses: a slow page sees no earlier moment of it. */
  let played = false;
  /** Time at which a restart of the loop was requested (s). */
  let left: number | null = null;
  const loopReplay = () => {
    const time = context.snapshot?.time ?? 0;
    const isOver = time >= end() - 0.02;
    if (!context.paused) played = true;
    else if (!isOver) played = false;
    const isOutside = isOver || time < begin();
    if (!isOutside) left = null;
    if (!isOutside || time === left || !loops || !played) return;
    left = time;
    void context.send({ do: "seek", time_s: begin(), play: true });
  };
  const step = () => {
    if (isReplay()) return loopReplay();
    if (at === null) return;
    const wall = performance.now();
    let time = at.time + ((wall - at.wall) / 1000) * Number(speed.value);
    if (time >= end()) {
      time = loops ? begin() : end();
      if (!loops) at = null;
    }
    if (at !== null) at = { time, wall };
    // Playback is of the history that is shown.
    look(time, store.past?.epoch ?? undefined);
  };
  setInterval(step, FRAME_MS);
  store.on("moment", (past) => {
    if (past === null) at = null;
  });
  const play = button(context, {
    icon: "play",
    label: "Play",
    name: () => (at === null ? "Play" : "Pause"),
    about: () => (at === null ? "Play the past from here" : "Pause the past"),
    twin: () => null,
    run: () => {
      const time = context.snapshot?.time ?? begin();
      const start = time >= end() - LEAST_S || time < begin() ? begin() : time;
      at = at === null ? { time: start, wall: performance.now() } : null;
    },
  });
  const toggle = () => {
    loops = !loops;
  };
  const loop = plainButton({ class: "button small", "aria-pressed": "false" }, toggle, "Loop");
  const loopAll = () => {
    range = null;
  };
  const clear = plainButton({ class: "button small quiet", title: "Loop over everything again" }, loopAll);
  const attrs = { class: "row playback", role: "group", "aria-label": "Playback of the past" };
  const root = el("div", attrs, play, speed, loop, clear);
  context.pulse.add(null, () => {
    root.hidden = !context.flag(FLAG.notLive) && !isReplay();
    // A recording has these two in the bar on top.
    play.hidden = isReplay();
    speed.hidden = isReplay();
    setIcon(play, at === null ? "play" : "pause");
    setAttr(loop, "aria-pressed", String(loops));
    loop.title =
      range === null
        ? "Play again from the beginning; Shift and drag on the bar to choose a range"
        : `Play ${range[0].toFixed(1)} s to ${range[1].toFixed(1)} s again and again`;
    clear.hidden = range === null;
    setText(clear, range === null ? "" : `${range[0].toFixed(1)}–${range[1].toFixed(1)} s ×`);
  });
  return {
    root,
    get range() {
      return range;
    },
    setRange(from, to) {
      const [first, last] = [Math.min(from, to), Math.max(from, to)];
      range = last - first < LEAST_S ? null : [first, last];
      loops = range !== null;
    },
    seek(time) {
      at = null;
      look(time);
    },
  };
}
