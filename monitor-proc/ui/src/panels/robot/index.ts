// The robot: how it stands, its joints, and leading it by hand.
import type { Actions } from "../actions";
import { gripperIsClosed } from "../actions";
import { button } from "../button";
import type { Desk } from "../desk";
import { el, setAttr, setText } from "../dom";
import { facts } from "./facts";
import { jointForm } from "./joint-form";
import { joints } from "./joints";
import { targetForm } from "./target";

export function robotTab(desk: Desk, act: Actions): HTMLElement {
  const arms = el("div", { class: "segments", role: "group", "aria-label": "Arm", hidden: true });
  const body = el("div", { class: "column" });
  const choose = () => {
    for (const [index, node] of [...arms.children].entries()) {
      setAttr(node, "aria-pressed", String(index === desk.arm));
    }
    body.replaceChildren(...armPanel(desk));
  };
  desk.store.on("scene", (scene) => {
    const buttons = scene.arms.map((arm, index) => {
      const node = el("button", { type: "button", class: "button small" }, arm.name);
      node.addEventListener("click", () => {
        desk.arm = index;
      });
      return node;
    });
    arms.replaceChildren(...buttons);
    arms.hidden = buttons.length < 2;
    choose();
  });
  desk.onArm(choose);
  const gripper = button(desk, { ...act.gripper, label: "Gripper", class: "gripper" });
  const name = gripper.querySelector("span");
  desk.pulse.add(gripper, () => {
    if (name !== null) setText(name, gripperIsClosed(desk) ? "Open gripper" : "Close gripper");
  });
  choose();
  return el("div", { class: "robot-tab column scroll" }, arms, body, targetForm(desk), el("div", { class: "row" }, gripper));
}

/** Facts, joints and joint targets of the selected arm. */
function armPanel(desk: Desk): HTMLElement[] {
  const arm = desk.store.scene?.arms[desk.arm];
  if (arm === undefined) return [el("p", { class: "dim hint" }, "No robot yet.")];
  return [facts(desk, desk.arm), joints(desk, desk.arm, arm), jointForm(desk, desk.arm, arm)];
}
