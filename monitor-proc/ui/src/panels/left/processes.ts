// The processes of the cell, and a restart button each.
import type { ProcessStatus } from "../../net/protocol";
import { FLAG } from "../../net/snapshot";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setOptions, setText, setTitle } from "../dom";
import { micros } from "../format";
import { setJoined } from "../status/joined";

interface Row {
  root: HTMLElement;
  show: (status: ProcessStatus) => void;
}

export function processes(context: PanelContext): HTMLElement {
  const none = el("p", { class: "dim" }, "No process has reported yet.");
  const list = el("div", { class: "processes of-now" }, none);
  context.store.on("hello", ({ live }) => {
    if (!live) setText(none, "A recording: nothing runs.");
  });
  const rows = new Map<string, Row>();
  context.store.on("status", (status) => {
    const names = status.processes.map((one) => one.name);
    if (names.join() !== [...rows.keys()].join()) {
      rows.clear();
      for (const name of names) rows.set(name, processRow(context, name));
      list.replaceChildren(...[...rows.values()].map((row) => row.root));
    }
    show();
  });
  // A rate is not one of now while nothing moves, and where nothing answers.
  const show = () => {
    for (const one of context.store.status?.processes ?? []) rows.get(one.name)?.show(one);
  };
  let shown = "";
  context.pulse.add(list, () => {
    const state = `${context.isStale} ${context.link} ${context.paused} ${context.flag(FLAG.lockstep)}`;
    if (state !== shown) show();
    shown = state;
  });
  return list;
}

function processRow(context: PanelContext, name: string): Row {
  const dot = el("i", { class: "dot" });
  const rate = el("span", { class: "num" });
  const late = el("span", { class: "num" });
  const more = el("div", { class: "dim more" });
  const fault = el("div", { class: "more fault", "data-tone": "warn", hidden: true });
  const policy = name === "task" ? policyChoice(context) : null;
  // Each arm's controller is listed, but they are started together.
  const process = name.replace(/-\d+$/, "");
  const other = () => policy !== null && policy.value !== "" && policy.value !== context.store.status?.task.policy;
  const restart = button(context, {
    icon: "reset",
    class: "icon-only quiet",
    about: () => `Restart ${process}${other() ? ` with policy ${policy?.value}` : ""}`,
    twin: () => `robocell restart ${process}${other() ? ` --policy ${policy?.value}` : ""}`,
    why: () => context.cellRefusal(),
    run: () => context.send({ do: "restart", process, ...(other() && policy ? { policy: policy.value } : {}) }),
  });
  const head = el("div", { class: "head" }, dot, el("b", { class: "name", title: name }, name), rate, late, restart);
  const root = el("div", { class: "process" }, head, fault, el("div", { class: "foot" }, more, policy));
  return { root, show: (status) => show(context, status, { root, dot, rate, late, more, fault }) };
}

const MONITOR = "monitor";
const TICKS_PER_S = 1000;
/** In the place of a rate in lockstep: those of several processes, each counted over a time of its own, would contradict each other. */
const IN_STEP = "in step";
const IN_STEP_WHY =
  "in lockstep: each cycle waits for the one before, so that the rate follows from the speed, at the top";

/** Scheduling in words. */
const PRIORITY: Record<string, string> = { fifo: "real-time priority", other: "normal priority" };

/** What a process does not do now, in a word; null while it works. */
function rests(context: PanelContext, status: ProcessStatus): string | null {
  if (context.isStale) return context.link;
  if (status.state !== "running") return status.state;
  // The monitor has a clock of its own.
  return context.paused && context.store.hello?.live === true && status.name !== MONITOR ? "paused" : null;
}

/** How often a process works, in short and as a sentence. */
function pace(context: PanelContext, { name, rate_hz }: ProcessStatus): [string, string] {
  if (context.flag(FLAG.lockstep) && name !== MONITOR) return [IN_STEP, IN_STEP_WHY];
  return [`${rate_hz.toFixed(0)} Hz`, `${rate_hz.toFixed(0)} cycles a second`];
}

type Parts = Record<"root" | "dot" | "rate" | "late" | "more" | "fault", HTMLElement>;

function show(context: PanelContext, status: ProcessStatus, at: Parts): void {
  const rest = rests(context, status);
  const running = status.state === "running";
  const idle = running && status.rate_hz < 0.5;
  const fault = status.note.startsWith("fault: ");
  const tone = fault ? "warn" : idle || rest !== null ? null : "ok";
  setAttr(at.dot, "data-tone", context.isStale ? null : running ? tone : "bad");
  const [short, sentence] = pace(context, status);
  const cycles = `${status.state}, ${sentence}`;
  const state = idle ? "running, but no cycle in the last second" : cycles;
  const paused = !idle && rest === "paused" ? "; simulated time is paused" : "";
  setTitle(at.dot, fault ? status.note : state + paused);
  setText(at.rate, rest ?? short);
  setTitle(at.rate, rest ?? sentence);
  setText(at.late, rest === null && status.late_p99_us > 0 ? micros(status.late_p99_us) : "–");
  const [p50, p99, max] = [status.late_p50_us, status.late_p99_us, status.late_max_us].map(micros);
  setTitle(at.late, `lateness p50 ${p50}, p99 ${p99}, max ${max}`);
  const restarts = (status.generation ?? 1) - 1;
  const facts = [PRIORITY[status.scheduling ?? ""] ?? "no report yet"];
  if (restarts > 0) facts.push(`restarted ${restarts}×`);
  if (status.missed > 0) facts.push(status.missed === 1 ? "1 cycle missed" : `${status.missed} cycles missed`);
  if (status.rejected > 0) facts.push(`${status.rejected} rejected`);
  if (status.fenced > 0) facts.push(`${status.fenced} fenced`);
  // A fault has its own line, and all of it can be read.
  at.fault.hidden = !fault;
  setText(at.fault, fault ? status.note : "");
  if (!fault && status.note !== "" && !isOver(context, status.note)) facts.push(status.note);
  setJoined(at.more, facts.join(" · "));
  if (status.missed_why !== "") facts.push(`missed: ${status.missed_why}`);
  setTitle(at.more, `pid ${status.pid ?? "–"} · ${facts.join(" · ")}`);
  at.root.classList.toggle("silent", !running && !context.isStale);
}

/** Whether a process waits no more for what its note says: its cell has ended, or simulated time advanced. */
function isOver({ isStale, snapshot }: PanelContext, note: string): boolean {
  const tick = /^tick (\d+) waits for /.exec(note)?.[1];
  return isStale || (tick !== undefined && Math.round(TICKS_PER_S * (snapshot?.time ?? 0)) > Number(tick));
}

/** With which policy the task starts again; of no use where there is one. */
function policyChoice(context: PanelContext): HTMLSelectElement {
  const select = el("select", { "aria-label": "Policy of the restarted task", class: "restart-policy" });
  const fill = () => {
    const { hello } = context.store;
    const demo = hello?.demos.find((one) => one.name === hello.run.demo);
    setOptions(select, demo?.policies ?? []);
    select.hidden = (demo?.policies.length ?? 0) < 2;
  };
  const follow = () => {
    const now = context.store.status?.task.policy;
    if (now !== undefined && now !== select.dataset.now) {
      select.dataset.now = now;
      select.value = now;
    }
  };
  context.store.on("hello", fill);
  context.store.on("status", follow);
  context.pulse.add(select, () => {
    const why = context.cellRefusal();
    select.disabled = why !== null;
    setTitle(select, `Policy the task is restarted with${why === null ? "" : `\nNot now: ${why}`}`);
  });
  fill();
  return select;
}
