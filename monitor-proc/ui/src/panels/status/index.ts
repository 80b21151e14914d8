// The bar above the 3D view with the state of the cell; also in the title of the window.
import type { Pose } from "../../net/protocol";
import { handRefusal } from "../actions";
import { type ButtonSpec, button, showButton } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { copyable } from "../guide/copy";
import { taskActions } from "../task/actions";
import { factsOf } from "./facts";
import { setJoined } from "./joined";
import { type Action, joined, type Line, lineOf } from "./words";

export function mountStatus(context: PanelContext, host: HTMLElement): void {
  const { store } = context;
  const state = el("b", { class: "state" });
  const detail = el("span", { class: "detail" });
  const command = el("span", { class: "command" });
  const specs = Object.entries(actions(context));
  const buttons = specs.map(([name, spec]) => ({ name: name as Action, node: button(context, spec) }));
  const said = el("div", { class: "said", role: "status" }, state, detail);
  host.replaceChildren(said, command, ...buttons.map(({ node }) => node));
  let shown = "";
  const show = () => {
    const line = lineOf(factsOf(context));
    const text = JSON.stringify(line);
    if (text === shown) return;
    shown = text;
    setAttr(host, "data-tone", line.tone);
    setText(state, line.state);
    setJoined(detail, line.detail);
    setTitle(detail, line.detail);
    command.replaceChildren(...(line.command === null ? [] : [copyable(context, line.command)]));
    for (const { name, node } of buttons) showButton(node, line.actions.includes(name));
    document.title = titleOf(line, store.hello?.run.demo);
  };
  context.pulse.add(null, () => {
    const { classList } = document.body;
    classList.toggle("no-task", store.earlier?.hasTask === false);
    classList.toggle("stale", context.isStale);
    classList.toggle("still", context.isStale || context.paused);
    show();
  });
  show();
}

function titleOf({ state, detail }: Line, demo: string | undefined): string {
  const short = detail.length > 40 ? `${detail.slice(0, 39)}…` : detail;
  return joined([short === "" ? state : `${state}: ${short}`, demo ?? "", "robocell"]);
}

/** Where the tool of the selected arm is. */
function tool({ snapshot, arm }: PanelContext): Pose {
  return snapshot?.arms[arm]?.tcp ?? [0, 0, 0, 1, 0, 0, 0];
}

/** Simulated time at which the task failed (s). */
function failedAt(context: PanelContext): number | null {
  const spans = context.store.lanes.filter(({ kind, label }) => kind === "task" && label === "failed");
  return spans.at(-1)?.from_s ?? null;
}

function actions(context: PanelContext): Record<Action, ButtonSpec> {
  const { again, start, resume } = taskActions(context);
  const why = () => context.cellRefusal();
  return {
    play: {
      label: "Play",
      about: () => "Let simulated time advance",
      twin: () => "robocell resume",
      why,
      primary: () => why() === null && !context.isTaskOver,
      run: () => context.send({ do: "resume" }),
    },
    again,
    start,
    resume,
    reset: {
      label: "Reset",
      about: () => "Put the scene back to its beginning, with the objects that are lost",
      twin: () => "robocell reset",
      why,
      primary: () => why() === null,
      run: () => context.send({ do: "reset" }),
    },
    tool: {
      label: "Target to the tool",
      about: () => "Set the target to where the tool is",
      twin: () => {
        const at = tool(context).slice(0, 3);
        const which = context.arm === 0 ? "" : ` --arm ${context.arm}`;
        return `robocell target ${at.map((value) => value.toFixed(4)).join(" ")}${which}`;
      },
      why: () => why() ?? handRefusal(context),
      primary: () => why() === null && !context.paused,
      run: () => {
        const [x, y, z, ...orientation_wxyz] = tool(context);
        return context.send({ do: "target", arm: context.arm, position: [x, y, z], orientation_wxyz });
      },
    },
    moment: {
      label: "Look at the moment",
      about: () => "Show the moment at which the task failed",
      twin: () => null,
      why: () => (failedAt(context) === null ? "the flight recorder does not hold that moment any more" : null),
      run: () => context.send({ do: "seek", time_s: failedAt(context) }),
    },
  };
}
