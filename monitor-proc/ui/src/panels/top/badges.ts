// The state of the run: real time, recorder, connection, and the role of the user.
import { FLAG } from "../../net/snapshot";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { recordingBadge } from "./recording";
import { roleBadge } from "./role";

const RT = {
  fifo: ["RT", "ok", "Real-time scheduling (SCHED_FIFO) for physics and controllers"],
  other: [
    "RT off",
    "warn",
    "Ordinary scheduling: the system refuses SCHED_FIFO. `robocell doctor` says how to allow it",
  ],
  lockstep: ["lockstep", "info", "Lockstep: every cycle waits for the one before; no clock is involved"],
} as const;

const LINKS = {
  connecting: ["info", "No message of the monitor yet"],
  "no answer": ["warn", "The monitor does not answer; the page connects again"],
  ended: [null, "The cell has ended; the page shows its last moment"],
  refused: ["bad", "This page belongs to a run that has ended"],
  replay: ["info", "A recording: "],
  past: ["info", "You look at the flight recorder; Live returns to the present"],
  live: ["ok", "Connected: the page shows the present"],
  paused: ["warn", "Connected: the page shows the present, and simulated time is paused"],
} as const;

export function badges(context: PanelContext): HTMLElement {
  const { store } = context;
  const rt = el("span", { class: "badge" }, "RT");
  const link = el("span", { class: "badge", role: "status" }, "connecting");

  const showRt = () => {
    const kind = context.flag(FLAG.lockstep) ? "lockstep" : store.status?.rt;
    // How it was scheduled tells nothing about a replay.
    rt.hidden = store.hello?.live === false;
    if (kind === undefined) return;
    const [name, tone, about] = RT[kind];
    setText(rt, name);
    // Nothing is scheduled in a cell that is paused or has ended.
    setAttr(rt, "data-tone", context.isStale || (tone === "ok" && context.paused) ? null : tone);
    setTitle(rt, about);
  };
  const showLink = () => {
    const replay = store.hello?.live === false;
    const past = context.flag(FLAG.notLive) && !replay;
    const now = past ? "past" : context.paused ? "paused" : "live";
    const name = context.link !== "connected" ? context.link : replay ? "replay" : now;
    setText(link, name);
    const [tone, about] = LINKS[name];
    setAttr(link, "data-tone", tone);
    setTitle(link, name === "replay" ? about + (store.hello?.source ?? "") : about);
    document.body.classList.toggle("offline", !store.connected);
    document.body.classList.toggle("past", past);
  };
  context.pulse.add(null, () => {
    showRt();
    showLink();
  });
  store.on("connection", showLink);
  return el("div", { class: "group badges" }, rt, recordingBadge(context), link, roleBadge(context));
}
