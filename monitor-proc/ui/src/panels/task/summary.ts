// One look at the task: outcome, phase, reason, and what went wrong how often.
import { afterDone, phaseOf } from "../../net/phases";
import type { Status } from "../../net/protocol";
import { FLAG } from "../../net/snapshot";
import type { Store } from "../../net/store";
import type { PanelContext } from "../context";
import { el, setAttr, setText, spacer } from "../dom";
import { words } from "../format";
import { factsOf } from "../status/facts";
import { taskOf } from "../status/words";
import { term } from "../terms";

const COUNTERS = [
  "drops",
  "resyncs",
  "aborts",
  "recoveries",
  "limit_violations",
  "obstacle_contacts",
  "self_contacts",
] as const;

const NAMES: Partial<Record<string, string>> = {
  limit_violations: "limits",
  obstacle_contacts: "contacts",
  self_contacts: "self-contacts",
};

const SINGULAR: Partial<Record<string, string>> = {
  drops: "drop",
  resyncs: "resync",
  aborts: "abort",
  recoveries: "recovery",
  limits: "limit",
  contacts: "contact",
  "self-contacts": "self-contact",
};

/** The state that is shown instead of now; empty for a cell that works. */
function insteadOfNow(context: PanelContext): string {
  if (context.isStale) return context.link;
  if (context.store.hello?.live === false) return "replay";
  if (context.flag(FLAG.notLive)) return "past";
  return context.paused ? "paused" : "";
}

/** Text and tone of the outcome, the same rule in every demo: `done`, `paused: running`, `ended: failed`. */
function outcomeOf(context: PanelContext): [string, string | null] {
  const instead = insteadOfNow(context);
  const { word, tone, isSpecial } = taskOf(factsOf(context));
  const text = context.isStale && context.paused && !isSpecial ? "paused" : word.toLowerCase();
  if (instead === "") return [text, tone];
  const other = context.isStale ? null : instead === "paused" ? "warn" : "info";
  return [`${instead}: ${text}`, tone === "bad" && !context.isStale ? "bad" : other];
}

/** What the task is at: its phase, or how it ended where it works no more. */
function titleOf(store: Store, { outcome }: Status["task"]): string {
  if (outcome === "failed") return "FAILED";
  if (outcome === "done" && !afterDone(store).isAgain) return "DONE";
  return words(phaseOf(store)) || "–";
}

/** `1 drop`, `2 drops`. */
function nameOf(key: string, count: number): string {
  const name = NAMES[key] ?? key;
  return count === 1 ? (SINGULAR[name] ?? name) : name;
}

export function taskSummary(context: PanelContext): HTMLElement {
  const outcome = el("span", { class: "badge" }, "–");
  const phase = el("b", { class: "phase" }, "no task yet");
  const policy = el("span", {});
  const age = el("span", { class: "num" });
  const decision = el("span", {}, " · ", term("decision"), " ", age);
  const source = el("span", { class: "dim" }, policy, decision);
  const reason = el("div", { class: "dim reason" });
  const wait = el("div", { class: "reason" });
  const counters = COUNTERS.map((key) => {
    const value = el("b", { class: "num" }, "0");
    const name = term(nameOf(key, 0));
    return { key, value, name, node: el("span", { class: "counter" }, value, name) };
  });
  const show = () => {
    const { store } = context;
    const task = store.status?.task;
    if (task === undefined) return;
    const [text, tone] = outcomeOf(context);
    const title = titleOf(store, task);
    setText(outcome, text);
    setAttr(outcome, "data-tone", tone);
    setText(phase, title);
    setAttr(phase, "data-tone", { FAILED: "bad", DONE: "ok" }[title] ?? null);
    setText(policy, task.policy);
    // The age of a decision is one of a cell that works.
    decision.hidden = insteadOfNow(context) !== "";
    setText(age, `${task.decision_age_ms.toFixed(0)} ms old`);
    setText(reason, words(task.reason));
    reason.hidden = task.reason === "";
    setText(wait, task.wait === "" ? "" : `waiting: ${task.wait}`);
    wait.hidden = task.wait === "";
    for (const { key, value } of counters) {
      setText(value, String(task[key]));
      value.classList.toggle("amber", task[key] > 0);
    }
    for (const { key, name } of counters) setText(name, nameOf(key, task[key]));
  };
  // With the bar above the view, so that both are of one moment.
  context.pulse.add(null, show);
  return el(
    "div",
    { class: "summary" },
    el("div", { class: "row" }, outcome, phase, spacer(), source),
    reason,
    wait,
    el("div", { class: "counters" }, ...counters.map(({ node }) => node)),
  );
}
