// Following a target: how far it is, whether the arm gets there, and targets to try.
import type { ArmSpec } from "../../net/protocol";
import { exampleTargets } from "../../net/reach";
import { type ArmState, isUnreachable } from "../../net/snapshot";
import { handRefusal } from "../actions";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setText, spacer } from "../dom";
import { millimetres } from "../format";

/** Nearer than this the arm is there (m). */
const THERE_M = 0.01;
const HINT = "Or drag the arrows at the tool; E turns it, T moves it. The tab Robot takes any target in numbers.";
/** Clearance of an arm without obstacles (m). */
const NO_OBSTACLE_M = 999;

export function mountReach(context: PanelContext, element: HTMLElement): () => void {
  const distance = el("b", { class: "num" });
  const verdict = el("b", { class: "badge" });
  const clearance = el("b", { class: "num" });
  const targets = el("div", { class: "reach-targets" });
  const fact = (name: string, value: HTMLElement) =>
    el("p", { class: "row" }, el("span", { class: "dim" }, name), spacer(), value);
  element.append(
    fact("Distance to the target", distance),
    fact("Target", verdict),
    fact("Clearance to obstacles", clearance),
    el("h3", {}, "Targets to try"),
    targets,
    el("p", { class: "dim" }, HINT),
  );
  let arm: ArmSpec | null = null;
  const show = () => {
    const spec = context.store.scene?.arms[context.arm] ?? null;
    if (spec !== arm) {
      arm = spec;
      targets.replaceChildren(...(spec === null ? [] : examples(context, spec)));
    }
    const state = context.snapshot?.arms[context.arm];
    if (state === undefined) return;
    const [words, tone] = verdictOf(state);
    setText(verdict, words);
    setAttr(verdict, "data-tone", tone);
    setText(distance, state.targetValid ? millimetres(state.positionError) : "–");
    setText(clearance, state.clearance > NO_OBSTACLE_M ? "no obstacle" : millimetres(state.clearance, 0));
  };
  context.pulse.add(element, show);
  show();
  return () => {};
}

function verdictOf(state: ArmState): [string, string | null] {
  if (!state.goalActive || !state.targetValid) return ["none yet", null];
  if (state.positionError < THERE_M) return ["reached", "ok"];
  if (isUnreachable(state)) return [state.notReached ?? "not reachable", "warn"];
  return [state.path === null ? "on the way" : "on a planned path", "info"];
}

/** A button for each example; the tool keeps its orientation, as on the command line. */
function examples(context: PanelContext, spec: ArmSpec): HTMLElement[] {
  return exampleTargets(spec).map(([label, position]) => {
    const which = context.arm === 0 ? "" : ` --arm ${context.arm}`;
    const node = button(context, {
      label,
      about: () => `Lead the tool to ${position.join(", ")} m; it keeps its orientation`,
      twin: () => `robocell target ${position.join(" ")}${which}`,
      why: () => context.cellRefusal() ?? handRefusal(context),
      run: () => {
        const [, , , ...orientation_wxyz] = context.snapshot?.arms[context.arm]?.tcp ?? [0, 0, 0, 1, 0, 0, 0];
        return context.send({ do: "target", arm: context.arm, position, orientation_wxyz });
      },
    });
    return el("div", { class: "row" }, node, el("code", { class: "dim" }, position.join(", "), " m"));
  });
}
