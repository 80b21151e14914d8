// How the arm is led by hand: axes, steps, at once or with Go; and buttons that move its target.
import { pointDown } from "../../hand/aims";
import type { Jog, Step } from "../../hand/jog";
import { HOLD, STEPS } from "../../hand/jog";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setAttr } from "../dom";

const AXES = ["x", "y", "z", "roll", "pitch", "yaw"] as const;

export function jogPanel(context: PanelContext, jog: Jog): HTMLElement {
  const { hand } = context;
  const refusal = () => hand.refusal();
  const steps = [...Object.keys(STEPS), HOLD] as Step[];
  const about = (step: Step) => (step === HOLD ? "Move as long as a button or a key is held" : `Move by ${step} with each press (with Shift a tenth)`);
  const root = el(
    "section",
    { class: "jog", "aria-label": "Jog" },
    el("h3", {}, "Jog"),
    el(
      "div",
      { class: "row wrap" },
      choice(context, "Step", steps, about, () => jog.step, (step) => (jog.step = step)),
      choice(context, "Axes", ["world", "tool"] as const, (frame) => `Axes of the ${frame}, for buttons, keys and the handle in the view`, () => hand.frame, (frame) => {
        hand.frame = frame;
        hand.changed();
      }),
      choice(context, "Motion", ["follow", "with Go"] as const, (way) => (way === "follow" ? "The arm follows every change at once" : "A transparent arm shows the target until Go is pressed"), () => (hand.follows ? "follow" : "with Go"), (way) => {
        hand.follows = way === "follow";
        hand.cancel();
      }),
    ),
    el("div", { class: "jog-keys" }, ...AXES.map((name, axis) => pair(context, jog, name, axis))),
  );
  const down = button(context, {
    label: "Point down",
    class: "small",
    about: () => "Turn the tool the shortest way until it points straight down",
    twin: () => null,
    why: refusal,
    run: () => aim(context),
  });
  const go = button(context, {
    label: "Go",
    class: "small",
    primary: () => hand.proposal !== null,
    about: () => "Move the arm to the target that is shown by the transparent arm (Enter)",
    twin: () => null,
    why: () => refusal() ?? (hand.proposal === null ? "no target is proposed: choose `with Go`, then move the target" : null),
    run: () => hand.go(),
  });
  root.append(el("div", { class: "row" }, down, go));
  addEventListener("keydown", (event) => {
    const target = event.target instanceof Element ? event.target : null;
    if (event.key !== "Enter" || hand.proposal === null || target?.closest("button, input, a, summary, dialog, [role=button]") != null) return;
    event.preventDefault();
    void hand.go();
  });
  return root;
}

function aim(context: PanelContext): void {
  const { hand, arm } = context;
  const from = hand.pose(arm);
  hand.begin();
  if (from !== null) hand.move(arm, pointDown(from, context.store.scene?.arms[arm]?.gripper ?? null));
}

/** A row of buttons of which one is chosen. */
function choice<T extends string>(context: PanelContext, label: string, all: readonly T[], about: (one: T) => string, now: () => T, choose: (one: T) => void): HTMLElement {
  const buttons = all.map((one) => {
    const node = el("button", { type: "button", class: "button small", title: about(one) }, one);
    node.addEventListener("click", () => choose(one));
    context.pulse.add(node, () => setAttr(node, "aria-pressed", String(now() === one)));
    return node;
  });
  return el("div", { class: "segments", role: "group", "aria-label": label }, ...buttons);
}

/** The two buttons of an axis. */
function pair(context: PanelContext, jog: Jog, name: string, axis: number): HTMLElement {
  const one = (sign: 1 | -1) => {
    const node = el("button", { type: "button", class: "button small", "aria-label": `${name} ${sign < 0 ? "minus" : "plus"}` }, sign < 0 ? "−" : "+");
    const press = (fine: boolean) => {
      const refusal = context.hand.refusal();
      if (refusal === null) jog.press(context.arm, axis, sign, fine);
      else context.notify(`not now: ${refusal}`);
    };
    node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      node.setPointerCapture(event.pointerId);
      press(event.shiftKey);
    });
    node.addEventListener("keydown", (event) => {
      if ((event.key !== "Enter" && event.key !== " ") || event.repeat) return;
      event.preventDefault();
      press(event.shiftKey);
    });
    for (const end of ["pointerup", "pointercancel", "keyup", "blur"]) node.addEventListener(end, () => jog.release());
    context.pulse.add(node, () => setAttr(node, "aria-disabled", context.hand.refusal() === null ? null : "true"));
    return node;
  };
  return el("div", { class: "jog-pair" }, el("span", { class: "dim" }, name), one(-1), one(1));
}
