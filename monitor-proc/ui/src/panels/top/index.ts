// The bar on top: which scene, its clock, and how things stand.
import { FLAG } from "../../net/snapshot";
import type { Actions } from "../actions";
import { button, setIcon } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { drawerButtons } from "../drawers";
import { badges } from "./badges";
import { sceneForm } from "./scene-form";

export function mountTop(
  context: PanelContext,
  host: HTMLElement,
  act: Actions,
  steps: HTMLInputElement,
  help: () => void,
): void {
  const clock = el("output", { class: "clock", title: "Simulated time" }, "–");
  const factor = el("output", { class: "factor", title: "Simulated seconds per second" }, "–");
  const cause = el("span", { class: "cause dim" });
  const play = button(context, act.playPause);
  const helpButton = button(context, {
    label: "?",
    class: "icon-only",
    about: () => "Keys and commands",
    twin: () => "robocell help",
    run: help,
  });
  setAttr(helpButton, "aria-label", "Help");
  host.replaceChildren(
    el("h1", { class: "brand" }, "robocell"),
    drawerButtons(),
    sceneForm(context),
    el(
      "div",
      { class: "group transport", role: "group", "aria-label": "Clock" },
      play,
      button(context, act.stop),
      button(context, act.step),
      el("label", { class: "steps-field dim" }, steps, "ms"),
      button(context, act.reset),
    ),
    el("div", { class: "group time" }, clock, factor, cause),
    el("div", { class: "spacer" }),
    badges(context),
    helpButton,
  );
  context.pulse.add(null, () => {
    const { snapshot } = context;
    // Nothing is to be paused where nothing runs.
    setIcon(play, context.paused || context.isStale || !snapshot ? "play" : "pause");
    play.classList.toggle("primary", context.paused && !context.isTaskOver);
    if (!snapshot) return;
    setText(clock, `${snapshot.time.toFixed(2)} s`);
    setTitle(clock, `Simulated time; tick ${snapshot.tick}`);
    const still = context.paused;
    // A rate of a cell that does not answer is none.
    const stale = context.isStale;
    setText(factor, stale ? context.link : still ? "paused" : `× ${snapshot.realTimeFactor.toFixed(2)}`);
    setTitle(factor, still ? pausedWhy(context) : "Simulated seconds per second");
    setText(cause, still && !stale ? pausedWhy(context) : "");
    const slow = !stale && !still && !context.flag(FLAG.lockstep) && snapshot.realTimeFactor < 0.95;
    factor.classList.toggle("amber", slow || (still && !stale));
  });
}

/** Why simulated time does not advance. */
export function pausedWhy(context: PanelContext): string {
  if (context.store.hello?.live === false) return "";
  const { status } = context.store;
  const causes = {
    start: "set up; Play starts it",
    operator: "by an operator",
    step: "the step is done",
    breakpoint: `${status?.pause_detail} was reached`,
    "": "",
  };
  return causes[status?.pause_cause ?? ""];
}

/** How many ticks a step runs. */
export function stepsInput(): HTMLInputElement {
  const attrs = { type: "number", min: 1, max: 1_000_000, value: 1, class: "steps" };
  return el("input", { ...attrs, "aria-label": "Ticks of a step", title: "Ticks of 1 ms that a step runs" });
}

export function stepsOf(input: HTMLInputElement): number {
  const count = Math.round(Number(input.value));
  return Number.isFinite(count) ? Math.min(Math.max(count, 1), 1_000_000) : 1;
}
