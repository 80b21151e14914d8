// One look at the task: outcome, phase, reason, and what went wrong how often.
import type { Status } from "../../net/protocol";
import type { PanelContext } from "../context";
import { el, setAttr, setText } from "../dom";
import { words } from "../format";
import { term } from "../terms";

const TONE: Record<Status["task"]["outcome"], string> = {
  idle: "info",
  running: "ok",
  done: "ok",
  failed: "bad",
  paused: "warn",
};

const COUNTERS = ["drops", "resyncs", "aborts", "recoveries", "limit_violations", "obstacle_contacts", "self_contacts"] as const;

const NAMES: Partial<Record<string, string>> = {
  limit_violations: "limits",
  obstacle_contacts: "contacts",
  self_contacts: "self-contacts",
};

/** Text and tone of the outcome: nothing runs while the clock is paused, in a replay, and in a cell that has ended. */
function outcomeOf({ store, paused }: PanelContext, outcome: Status["task"]["outcome"]): [string, string] {
  if (outcome !== "running") return [outcome, TONE[outcome]];
  if (!store.connected) return ["ended", "info"];
  if (store.hello?.live === false) return ["replay", "info"];
  return paused ? ["paused", "warn"] : [outcome, TONE[outcome]];
}

export function taskSummary(context: PanelContext): HTMLElement {
  const outcome = el("span", { class: "badge" }, "–");
  const phase = el("b", { class: "phase" }, "no task yet");
  const policy = el("span", {});
  const age = el("span", { class: "num" });
  const source = el("span", { class: "dim" }, policy, " · ", term("decision"), " ", age);
  const reason = el("div", { class: "dim reason" });
  const wait = el("div", { class: "reason" });
  const counters = COUNTERS.map((key) => {
    const value = el("b", { class: "num" }, "0");
    const name = NAMES[key] ?? key;
    return { key, value, node: el("span", { class: "counter" }, value, term(name)) };
  });
  const showOutcome = () => {
    const task = context.store.status?.task;
    if (task === undefined) return;
    const [text, tone] = outcomeOf(context, task.outcome);
    setText(outcome, text);
    setAttr(outcome, "data-tone", tone);
  };
  context.pulse.add(outcome, showOutcome);
  context.store.on("status", ({ task }) => {
    showOutcome();
    setText(phase, words(task.phase) || "–");
    setText(policy, task.policy);
    setText(age, `${task.decision_age_ms.toFixed(0)} ms old`);
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
    el("div", { class: "row" }, outcome, phase, el("span", { class: "spacer" }), source),
    reason,
    wait,
    el("div", { class: "counters" }, ...counters.map(({ node }) => node)),
  );
}
