// The bar above the 3D view with the state of the cell; also in the title of the window.
import { FLAG, isUnreachable, OBJECT } from "../../net/snapshot";
import { button, type ButtonSpec } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { copyable } from "../guide/copy";
import { taskActions } from "../task/actions";
import { pausedWhy } from "../top/index";
import { type Action, type Facts, type Line, lineOf } from "./words";

export function mountStatus(context: PanelContext, host: HTMLElement): void {
  const { store } = context;
  const state = el("b", { class: "state" });
  const detail = el("span", { class: "detail" });
  const command = el("span", { class: "command" });
  const buttons = Object.entries(actions(context)).map(([name, spec]) => ({ name: name as Action, node: button(context, spec) }));
  const said = el("div", { class: "said", role: "status" }, state, detail);
  host.replaceChildren(said, command, ...buttons.map(({ node }) => node));
  let heard_ms: number | null = null;
  const hear = () => {
    heard_ms = Date.now();
  };
  store.on("snapshot", hear);
  store.on("status", hear);
  let shown = "";
  const show = () => {
    const line = lineOf(factsOf(context, heard_ms));
    const text = JSON.stringify(line);
    if (text === shown) return;
    shown = text;
    setAttr(host, "data-tone", line.tone);
    setText(state, line.state);
    setText(detail, line.detail);
    setTitle(detail, line.detail);
    command.replaceChildren(...(line.command === null ? [] : [copyable(context, line.command)]));
    for (const { name, node } of buttons) node.hidden = !line.actions.includes(name);
    document.body.classList.toggle("stale", line.tone === "stale");
    document.title = titleOf(line, store.hello?.run.demo);
  };
  context.pulse.add(null, () => {
    document.body.classList.toggle("no-task", store.earlier?.hasTask === false);
    show();
  });
  store.on("connection", show);
  show();
}

function titleOf({ state, detail }: Line, demo: string | undefined): string {
  const short = detail.length > 40 ? `${detail.slice(0, 39)}…` : detail;
  return [short === "" ? state : `${state}: ${short}`, demo ?? "", "robocell"].filter((part) => part !== "").join(" · ");
}

function factsOf(context: PanelContext, heard_ms: number | null): Facts {
  const { store, snapshot } = context;
  const { hello, status, scene } = store;
  const arms = scene?.arms ?? [];
  const held = (snapshot?.arms ?? []).flatMap(({ held }, arm) => {
    const name = held === null ? undefined : scene?.objects[held]?.name;
    if (name === undefined) return [];
    return [arms.length > 1 ? `${arms[arm]?.name ?? ""} holds ${name}` : `holds ${name}`];
  });
  const objects = (scene?.objects ?? []).filter(({ parked }, index) => {
    const flags = snapshot?.objects[index]?.flags ?? OBJECT.enabled;
    return parked !== true && (flags & OBJECT.enabled) === 0;
  });
  const shown_s = snapshot?.time ?? 0;
  return {
    connected: store.connected,
    refused: store.refused,
    ended: store.ended,
    hello,
    heard_ms,
    now_ms: Date.now(),
    task: status?.task ?? null,
    shown_s,
    newest_s: Math.max(store.timeline?.to_s ?? 0, shown_s),
    past: context.flag(FLAG.notLive),
    earlierSeed: store.earlier?.seed ?? null,
    paused: context.paused,
    pauseCause: pausedWhy(context),
    taskPaused: context.flag(FLAG.taskPaused),
    startEvent: scene?.start_event === true,
    held,
    unreached: unreached(context),
    lost: objects.map(({ name }) => name),
    incidents: new Set(store.marked.flatMap(({ incident }) => incident ?? [])).size,
  };
}

/** Of a task that only follows a person's target: a job knows what to do about it. */
function unreached({ snapshot, store: { scene } }: PanelContext): string {
  if (scene?.task["kind"] !== "reach") return "";
  const arm = snapshot?.arms.find(isUnreachable);
  return arm === undefined ? "" : `target not reached (${arm.notReached ?? "unreachable"}), ${(1000 * arm.positionError).toFixed(0)} mm away`;
}

/** Simulated time at which the task failed (s). */
function failedAt(context: PanelContext): number | null {
  const spans = context.store.lanes.filter(({ kind, label }) => kind === "task" && label === "failed");
  return spans.at(-1)?.from_s ?? null;
}

function actions(context: PanelContext): Record<Action, ButtonSpec> {
  const { again, start, resume } = taskActions(context);
  return {
    again,
    start,
    resume,
    moment: {
      label: "Look at the moment",
      about: () => "Show the moment at which the task failed",
      twin: () => null,
      why: () => (failedAt(context) === null ? "the flight recorder does not hold that moment any more" : null),
      run: () => context.send({ do: "seek", time_s: failedAt(context) }),
    },
    play: {
      label: "Play",
      about: () => "Let simulated time advance",
      twin: () => "robocell resume",
      why: () => context.cellRefusal(),
      run: () => context.send({ do: "resume" }),
    },
  };
}
