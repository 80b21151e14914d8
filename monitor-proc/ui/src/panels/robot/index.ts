// The robot: its state, its joints, and leading it by hand.
import type { Jog } from "../../hand/jog";
import { type Actions, gripperIsClosed } from "../actions";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr } from "../dom";
import { facts } from "./facts";
import { jogPanel } from "./jog";
import { jointForm } from "./joint-form";
import { joints } from "./joints";
import { targetForm } from "./target";

export function robotTab(context: PanelContext, act: Actions, jog: Jog): HTMLElement {
  const arms = el("div", { class: "segments", role: "group", "aria-label": "Arm", hidden: true });
  const body = el("div", { class: "column" });
  const sliders = el("div");
  const choose = () => {
    for (const [index, node] of [...arms.children].entries()) {
      setAttr(node, "aria-pressed", String(index === context.arm));
    }
    body.replaceChildren(...armPanel(context));
    const arm = context.store.scene?.arms[context.arm];
    sliders.replaceChildren(...(arm === undefined ? [] : [jointForm(context, context.arm, arm)]));
  };
  context.store.on("scene", (scene) => {
    const lead = (index: number) => {
      context.arm = index;
    };
    const buttons = scene.arms.map(({ name }, index) =>
      plainButton({ class: "button small" }, () => lead(index), name),
    );
    arms.replaceChildren(...buttons);
    arms.hidden = buttons.length < 2;
    choose();
  });
  context.onArm(choose);
  const name = () => (gripperIsClosed(context) ? "Open gripper" : "Close gripper");
  const gripper = button(context, { ...act.gripper, label: "Gripper", class: "gripper", name });
  choose();
  const [form, byHand] = [targetForm(context), [el("div", { class: "row" }, gripper), jogPanel(context, jog)]];
  const root = el("div", { class: "robot-tab column scroll" }, arms, body, form, ...byHand, sliders);
  let leads = false;
  context.pulse.add(root, () => {
    if (leads === (context.hand.refusal() === null)) return;
    leads = !leads;
    // What leads the arm comes first while it can; otherwise the state of the arm does.
    (leads ? arms : form).after(...byHand);
  });
  return root;
}

/** Facts and joints of the selected arm. */
function armPanel(context: PanelContext): HTMLElement[] {
  const arm = context.store.scene?.arms[context.arm];
  if (arm === undefined) return [el("p", { class: "dim hint" }, "No robot yet.")];
  return [facts(context, context.arm), joints(context, context.arm, arm)];
}
