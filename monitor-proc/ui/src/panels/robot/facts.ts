// One arm in a few lines: its stop, the object it holds, its distance to the target.
import { type ArmState, isUnreachable } from "../../net/snapshot";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { millimetres } from "../format";
import { list } from "../inspect/rows";
import { stopWords } from "../stop-words";
import { term } from "../terms";

/** Rows whose text needs the whole width. */
const WIDE = /^(TCP|opening|suction|distance)/;
/** Clearance of an arm without obstacles (m). */
const NO_OBSTACLE_M = 999;

export function facts(context: PanelContext, arm: number): HTMLElement {
  const controller = stopBadge("controller");
  const physics = stopBadge("drives");
  const rows: [string, (state: ArmState) => string][] = [
    ["goal", (state) => goalWords(state)],
    ["distance to target", (state) => (state.targetValid ? millimetres(state.positionError) : "–")],
    ["clearance", (state) => (state.clearance > NO_OBSTACLE_M ? "no obstacle" : millimetres(state.clearance, 0))],
    ["holds", (state) => (state.held === null ? "nothing" : (context.store.scene?.objects[state.held]?.name ?? "?"))],
    ...gripperRows(context, arm),
    ["TCP (m)", (state) => list(state.tcp.slice(0, 3), 4)],
  ];
  const cells = rows.map(([name, text]) => {
    const value = el("b", { class: "num" }, "–");
    const kind = WIDE.test(name) ? "fact wide" : "fact";
    const label = el("span", { class: "dim" }, term(name, name.replace(" (m)", "")));
    return { value, text, node: el("div", { class: kind }, label, value) };
  });
  const stops = el("div", { class: "stops" }, controller.node, physics.node);
  const root = el("div", { class: "facts" }, stops, ...cells.map(({ node }) => node));
  context.pulse.add(root, () => {
    const state = context.snapshot?.arms[arm];
    if (!root.isConnected || !state) return;
    controller.show(state.controllerStop, false);
    physics.show(state.physicsStop, state.fault);
    for (const { value, text } of cells) setText(value, text(state));
  });
  return root;
}

/** What became of the goal; an arm at rest away from it does not get there. */
function goalWords(state: ArmState): string {
  if (!state.goalActive) return "none";
  if (!state.targetValid) return "followed, no pose";
  return isUnreachable(state) ? "not reachable" : "followed";
}

function gripperRows(context: PanelContext, arm: number): [string, (state: ArmState) => string][] {
  const gripper = context.store.scene?.arms[arm]?.gripper;
  if (!gripper) return [];
  if (gripper.finger_joints.length === 0) {
    return [["suction", (state) => `${state.attached ? "attached" : "free"}, load ${(100 * state.load).toFixed(0)} %`]];
  }
  return [
    ["opening", (state) => `${millimetres(state.width)} of ${millimetres(gripper.max_width_m, 0)}`],
    ["grip force", (state) => `${state.force.toFixed(1)} N`],
  ];
}

function stopBadge(who: string) {
  const badge = el("span", { class: "badge" }, "–");
  const about = el("span", { class: "dim" });
  return {
    node: el("div", { class: "stop" }, el("span", { class: "who" }, who), badge, about),
    show(code: number, fault: boolean) {
      const words = stopWords(code);
      setText(badge, fault ? "Fault" : words.name);
      setAttr(badge, "data-tone", fault ? "bad" : words.tone);
      setText(about, words.about);
      setTitle(about, words.about);
    },
  };
}
