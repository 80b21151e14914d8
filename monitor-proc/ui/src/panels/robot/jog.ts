// How the arm is led by hand: axes, steps, at once or with Go; and buttons that move its target.
import { pointDown } from "../../hand/aims";
import { HOLD, type Jog, STEPS, type Step } from "../../hand/jog";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, plainButton, setAttr } from "../dom";

const NO_PROPOSAL = "no target is proposed: choose `with Go`, then move the target";
const MOTIONS = {
  follow: "The arm follows every change at once",
  "with Go": "A transparent arm shows the target until Go is pressed",
};
const AXES = ["x", "y", "z", "roll", "pitch", "yaw"] as const;

export function jogPanel(context: PanelContext, jog: Jog): HTMLElement {
  const { hand } = context;
  const refusal = () => hand.refusal();
  const steps = Object.keys(STEPS).map((step) => [step, `Move by ${step} with each press (with Shift a tenth)`]);
  const about = { ...Object.fromEntries(steps), [HOLD]: "Move as long as a button or a key is held" };
  const axis = (of: string) => `Axes of the ${of}, for buttons, keys and the handle in the view`;
  const axes = { world: axis("world"), tool: axis("tool") };
  const setStep = (step: string) => {
    jog.step = step as Step;
  };
  const setFrame = (frame: keyof typeof axes) => {
    hand.frame = frame;
    hand.changed();
  };
  const setMotion = (motion: keyof typeof MOTIONS) => {
    hand.follows = motion === "follow";
    hand.cancel();
  };
  const root = el(
    "section",
    { class: "jog", "aria-label": "Jog" },
    el("h3", {}, "Jog"),
    el(
      "div",
      { class: "row wrap" },
      choice(context, "Step", about, () => jog.step, setStep),
      choice(context, "Axes", axes, () => hand.frame, setFrame),
      choice(context, "Motion", MOTIONS, () => (hand.follows ? "follow" : "with Go"), setMotion),
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
    why: () => refusal() ?? (hand.proposal === null ? NO_PROPOSAL : null),
    run: () => hand.go(),
  });
  root.append(el("div", { class: "row" }, down, go));
  addEventListener("keydown", (event) => {
    const target = event.target instanceof Element ? event.target : null;
    const isTaken = target?.closest("button, input, a, summary, dialog, [role=button]") != null;
    if (event.key !== "Enter" || hand.proposal === null || isTaken) return;
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

/** A row of buttons of which one is chosen; `all` has their titles. */
function choice<T extends string>(
  context: PanelContext,
  label: string,
  all: Record<T, string>,
  now: () => T,
  choose: (one: T) => void,
): HTMLElement {
  const buttons = (Object.entries(all) as [T, string][]).map(([one, title]) => {
    const node = plainButton({ class: "button small", title }, () => choose(one), one);
    context.pulse.add(node, () => setAttr(node, "aria-pressed", String(now() === one)));
    return node;
  });
  return el("div", { class: "segments", role: "group", "aria-label": label }, ...buttons);
}

/** The two buttons of an axis. */
function pair(context: PanelContext, jog: Jog, name: string, axis: number): HTMLElement {
  const one = (sign: 1 | -1) => {
    const attrs = { type: "button", class: "button small", "aria-label": `${name} ${sign < 0 ? "minus" : "plus"}` };
    const node = el("button", attrs, sign < 0 ? "−" : "+");
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
