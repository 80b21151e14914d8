// The suction cup: what hangs at it, how near it is to letting go, and a button.
import { gripperIsClosed, handRefusal } from "../actions";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr, setText } from "../dom";

const HIGH = 0.8;

/** `once`, `3 times`. */
function times(count: number): string {
  return count === 1 ? "once" : `${count} times`;
}

/** Load gauge, what the cup feels, and how it let go last; for arm 0. */
export function suctionGauge(context: PanelContext): HTMLElement {
  const gripper = context.store.scene?.arms[0]?.gripper;
  const fill = el("i", { class: "gauge-fill" });
  const text = el("b", { class: "num" });
  const feels = el("span", { class: "dim num" });
  const last = el("p", { class: "dim" });
  const root = el(
    "div",
    { class: "suction-panel" },
    el("div", { class: "row" }, el("span", {}, "Load"), el("div", { class: "gauge" }, fill), text),
    feels,
    last,
    openClose(context),
  );
  context.pulse.add(root, () => {
    const arm = context.snapshot?.arms[0];
    const cup = context.store.status?.equipment?.suction[0];
    if (!root.isConnected || arm === undefined) return;
    const load = Math.min(Math.max(arm.load, 0), 1);
    fill.style.width = `${(100 * load).toFixed(1)}%`;
    setAttr(fill, "data-near", load > HIGH ? "very" : null);
    setText(text, arm.attached ? `${(100 * load).toFixed(0)} %` : "nothing attached");
    if (cup === undefined) return;
    const force = `${cup.force_n.toFixed(1)} of ${gripper?.force_limit_n ?? 0} N`;
    const torque = `${cup.torque_n_m.toFixed(2)} of ${gripper?.torque_limit_n_m ?? 0} N m`;
    setText(feels, `${force}, ${torque}; peak ${cup.peak_force_n.toFixed(0)} N`);
    const how = `last at its limit of ${cup.break_limit} by ${cup.break_cause}`;
    const broke = cup.breaks === 0 ? "" : `It let go ${times(cup.breaks)}, ${how}. `;
    const refused = cup.refusals === 0 ? "" : `It refused ${times(cup.refusals)}, last because ${cup.refusal}.`;
    setText(last, broke + refused);
  });
  return root;
}

/** One button that opens and closes the gripper of arm 0. */
function openClose(context: PanelContext): HTMLElement {
  const to = () => (gripperIsClosed(context) ? "open" : "close");
  return button(context, {
    label: "Close gripper",
    name: () => (to() === "open" ? "Open gripper" : "Close gripper"),
    about: () => (to() === "open" ? "Release" : "Switch suction on"),
    twin: () => `robocell gripper ${to()}`,
    why: () => context.cellRefusal() ?? handRefusal(context),
    run: () => context.send({ do: "gripper", arm: 0, to: to() }),
  });
}
