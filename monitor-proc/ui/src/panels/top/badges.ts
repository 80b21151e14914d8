// The state of the run: real time, recorder, connection, and the role of the user.
import { FLAG } from "../../net/snapshot";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { recordingBadge } from "./recording";
import { roleBadge } from "./role";

const RT = {
  fifo: ["RT", "ok", "Real-time scheduling (SCHED_FIFO) for physics and controllers"],
  other: ["RT off", "warn", "Ordinary scheduling: the system refuses SCHED_FIFO. `robocell doctor` says how to allow it"],
  lockstep: ["lockstep", "info", "Lockstep: every cycle waits for the one before; no clock is involved"],
} as const;

const TONES = { live: "ok", paused: "warn", replay: "info", past: "info", connecting: "info", "no answer": "warn", ended: null, refused: "bad" } as const;

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
    const name = context.link !== "connected" ? context.link : replay ? "replay" : past ? "past" : context.paused ? "paused" : "live";
    setText(link, name);
    setAttr(link, "data-tone", TONES[name]);
    const about = {
      connecting: "No message of the monitor yet",
      "no answer": "The monitor does not answer; the page connects again",
      ended: "The cell has ended; the page shows its last moment",
      refused: "This page belongs to a run that has ended",
      replay: `A recording: ${store.hello?.source ?? ""}`,
      past: "You look at the flight recorder; Live returns to the present",
      live: "Connected: the page shows the present",
      paused: "Connected: the page shows the present, and simulated time is paused",
    }[name];
    setTitle(link, about);
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
