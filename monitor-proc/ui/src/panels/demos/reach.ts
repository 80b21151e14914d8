// Following a target: how far it is, whether the arm gets there, and targets to try.
import type { ArmSpec, Vec3 } from "../../net/protocol";
import { type ArmState, isUnreachable } from "../../net/snapshot";
import { handRefusal } from "../actions";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setText } from "../dom";
import { millimetres } from "../format";

/** Nearer than this the arm is there (m). */
const THERE_M = 0.01;
/** Clearance of an arm without obstacles (m). */
const NO_OBSTACLE_M = 999;

/** In lengths of the stretched arm, from its base. */
const EXAMPLES: [string, Vec3][] = [
  ["In front", [0.34, 0, 0.34]],
  ["Low, to the side", [0.3, -0.24, 0.2]],
  ["Out of reach", [1.3, 0, 0.34]],
];
const GRID_M = 0.05;

export function mountReach(context: PanelContext, element: HTMLElement): () => void {
  const distance = el("b", { class: "num" });
  const verdict = el("b", { class: "badge" });
  const clearance = el("b", { class: "num" });
  const targets = el("div", { class: "reach-targets" });
  const fact = (name: string, value: HTMLElement) => el("p", { class: "row" }, el("span", { class: "dim" }, name), el("span", { class: "spacer" }), value);
  element.append(
    fact("Distance to the target", distance),
    fact("Target", verdict),
    fact("Clearance to obstacles", clearance),
    el("h3", {}, "Targets to try"),
    targets,
    el("p", { class: "dim" }, "Or drag the arrows at the tool; E turns it, T moves it. The tab Robot takes any target in numbers."),
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
  const length = stretched(spec);
  return EXAMPLES.map(([label, shares]) => {
    const position = shares.map((share, axis) => round((spec.base.position[axis] ?? 0) + share * length)) as Vec3;
    const which = context.arm === 0 ? "" : ` --arm ${context.arm}`;
    const node = button(context, {
      label,
      about: () => `Lead the tool to ${position.join(", ")} m; it keeps its orientation`,
      twin: () => `robocell target ${position.join(" ")}${which}`,
      why: () => context.cellRefusal() ?? handRefusal(context),
      run: () => {
        const tcp = context.snapshot?.arms[context.arm]?.tcp ?? [0, 0, 0, 1, 0, 0, 0];
        return context.send({ do: "target", arm: context.arm, position, orientation_wxyz: [tcp[3], tcp[4], tcp[5], tcp[6]] });
      },
    });
    return el("div", { class: "row" }, node, el("code", { class: "dim" }, position.join(", "), " m"));
  });
}

/** Length of the arm from joint to joint (m): no point farther away can be reached. */
function stretched({ urdf, joints, arm_joints }: ArmSpec): number {
  const names = new Set(joints.slice(0, arm_joints).map(({ name }) => name));
  const found = new DOMParser().parseFromString(urdf, "application/xml").querySelectorAll("joint");
  let length = 0;
  for (const joint of found) {
    if (!names.has(joint.getAttribute("name") ?? "")) continue;
    const offset = (joint.querySelector("origin")?.getAttribute("xyz") ?? "").trim().split(/\s+/).map(Number);
    if (offset.every(Number.isFinite)) length += Math.hypot(...offset);
  }
  return length > 0 ? length : 1;
}

function round(metres: number): number {
  return Number((Math.round(metres / GRID_M) * GRID_M).toFixed(2));
}
