// One look at the task: outcome, phase, reason, and what went wrong how often.
import type { Status } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { words } from "../format";

const TONE: Record<Status["task"]["outcome"], string> = {
  idle: "info",
  running: "ok",
  done: "ok",
  failed: "bad",
  paused: "warn",
};

const COUNTERS = [
  ["drops", "Held objects that were lost"],
  ["resyncs", "Pick-ups restarted because the object moved"],
  ["aborts", "Transfers turned back because the stack below was gone"],
  ["recoveries", "Recoveries of any other kind"],
  ["limit_violations", "Limits of the robot that were violated, as physics measured"],
  ["obstacle_contacts", "Times an arm touched an obstacle or another arm"],
  ["self_contacts", "Times parts of an arm touched each other"],
] as const;

const NAMES: Partial<Record<string, string>> = {
  limit_violations: "limits",
  obstacle_contacts: "contacts",
  self_contacts: "self-contacts",
};

export function taskSummary(context: PanelContext): HTMLElement {
  const outcome = el("span", { class: "badge" }, "–");
  const phase = el("b", { class: "phase" }, "no task yet");
  const policy = el("span", { class: "dim" });
  const reason = el("div", { class: "dim reason" });
  const wait = el("div", { class: "reason" });
  const counters = COUNTERS.map(([key, about]) => {
    const value = el("b", { class: "num" }, "0");
    const name = NAMES[key] ?? key;
    return { key, value, node: el("span", { class: "counter", title: about }, value, name) };
  });
  context.store.on("status", ({ task }) => {
    setText(outcome, task.outcome);
    setAttr(outcome, "data-tone", TONE[task.outcome]);
    setText(phase, words(task.phase) || "–");
    setText(policy, `${task.policy} · decision ${task.decision_age_ms.toFixed(0)} ms old`);
    setTitle(policy, "Policy, and the age of its newest decision");
    setText(reason, words(task.reason));
    reason.hidden = task.reason === "";
    setText(wait, task.wait === "" ? "" : `waiting: ${task.wait}`);
    wait.hidden = task.wait === "";
    for (const { key, value } of counters) {
      setText(value, String(task[key]));
      value.classList.toggle("amber", task[key] > 0);
    }
  });
  return el(
    "div",
    { class: "summary" },
    el("div", { class: "row" }, outcome, phase, el("span", { class: "spacer" }), policy),
    reason,
    wait,
    el("div", { class: "counters" }, ...counters.map(({ node }) => node)),
  );
}
