// A target of the tool in numbers.
import type { Vec3 } from "../../net/protocol";
import { handRefusal } from "../actions";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setText } from "../dom";
import { fromRpy, toRpy } from "./rotation";

const RAD = Math.PI / 180;
const FIELDS = ["x", "y", "z", "roll", "pitch", "yaw"] as const;

export function targetForm(context: PanelContext): HTMLElement {
  const inputs = FIELDS.map((name, index) =>
    el("input", { type: "number", step: index < 3 ? 0.005 : 1, "aria-label": name, title: index < 3 ? `${name} in metres, world frame` : `${name} in degrees` }),
  );
  const numbers = () => inputs.map((input) => Number.parseFloat(input.value));
  const why = () => {
    const refusal = context.cellRefusal() ?? handRefusal(context);
    if (refusal !== null) return refusal;
    return numbers().every(Number.isFinite) ? null : "a field is empty";
  };
  /**
   * Until the user starts to type, and again once a target was accepted, the fields show the
   * target that leads the arm, as the arrows do, else the tool.
   */
  let following = true;
  /** The target at which the fields were told to show the tool. */
  let passed = "";
  let wasPaused = false;
  /** An accepted target that the controller may not have taken yet. */
  let sent: { arm: number; fields: string; before: string } | null = null;
  const texts = () => inputs.map((input) => input.value).join();
  const targetNow = () => {
    const state = context.snapshot?.arms[context.arm];
    return state?.targetValid === true ? JSON.stringify(state.target) : "";
  };
  const show = () => {
    const state = context.snapshot?.arms[context.arm];
    if (state === undefined) return;
    const isLed = handRefusal(context) === null && targetNow() !== passed && targetNow() !== "";
    const pose = isLed ? state.target : state.tcp;
    const turn = toRpy([pose[3], pose[4], pose[5], pose[6]]);
    const values = [...pose.slice(0, 3).map((v) => v.toFixed(4)), ...turn.map((v) => (v / RAD).toFixed(2))];
    for (const [index, input] of inputs.entries()) input.value = values[index] ?? "";
  };
  const which = () => (context.arm === 0 ? "" : ` --arm ${context.arm}`);
  const go = button(context, {
    label: "Go",
    // A target that is in force needs no highlighted button.
    primary: () => !following,
    about: () => "Lead the tool to this target (metres and degrees, world frame)",
    twin: () => {
      const all = numbers();
      return `robocell target ${all.map((v) => (Number.isFinite(v) ? v.toFixed(4) : "?")).join(" ")}${which()} --deg`;
    },
    why,
    run: () => {
      const [x = 0, y = 0, z = 0, roll = 0, pitch = 0, yaw = 0] = numbers();
      const position: Vec3 = [x, y, z];
      const turn = fromRpy(roll * RAD, pitch * RAD, yaw * RAD);
      const asked = { arm: context.arm, fields: texts(), before: targetNow() };
      return context.send({ do: "target", arm: asked.arm, position, orientation_wxyz: turn }).then((accepted) => {
        // After a refusal the fields keep their numbers.
        if (accepted) sent = asked;
      });
    },
  });
  const here = button(context, {
    label: "From robot",
    about: () => "Show where the tool is, until a field is typed into",
    twin: () => null,
    run: () => {
      following = true;
      passed = targetNow();
      show();
    },
  });
  const reason = el("p", { class: "dim" });
  const form = el(
    "form",
    { class: "target-form", "aria-label": "Target of the tool" },
    el("h3", {}, "Target of the tool"),
    el("div", { class: "target-fields" }, ...FIELDS.map((name, index) => el("label", {}, `${name} (${index < 3 ? "m" : "°"})`, inputs[index] ?? ""))),
    el("div", { class: "row" }, here, go, reason),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    go.click();
  });
  for (const event of ["focusin", "input"]) {
    form.addEventListener(event, ({ target }) => {
      if (target instanceof HTMLInputElement) following = false;
    });
  }
  context.onArm(() => {
    following = true;
    passed = targetNow();
  });
  // Hidden, too: a user who starts to type finds all fields filled in.
  context.pulse.add(null, () => {
    const isPaused = handRefusal(context) === null;
    // What the task aimed at when it was paused leads no longer.
    if (isPaused && !wasPaused) passed = targetNow();
    wasPaused = isPaused;
    if (sent !== null && targetNow() !== sent.before) {
      if (sent.arm === context.arm && sent.fields === texts()) {
        following = true;
        passed = "";
      }
      sent = null;
    }
    if (following) show();
  });
  context.pulse.add(form, () => setText(reason, why() ?? ""));
  return form;
}
