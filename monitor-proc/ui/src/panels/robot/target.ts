// A target of the tool in numbers.
import { CONTACT_LIMIT_N } from "../../hand/hand";
import type { Pose } from "../../net/protocol";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el, setText } from "../dom";
import { fromRpy, toRpy } from "./rotation";

const RAD = Math.PI / 180;
const FIELDS = ["x", "y", "z", "roll", "pitch", "yaw"] as const;

export function targetForm(context: PanelContext): HTMLElement {
  const { hand } = context;
  const inputs = FIELDS.map((name, index) => {
    const [step, unit] = index < 3 ? [0.005, "metres, world frame"] : [1, "degrees"];
    return el("input", { type: "number", step, "aria-label": name, title: `${name} in ${unit}` });
  });
  const labels = FIELDS.map((name, index) =>
    el("label", {}, `${name} (${index < 3 ? "m" : "°"})`, inputs[index] ?? ""),
  );
  const numbers = () => inputs.map((input) => Number.parseFloat(input.value));
  const why = () => {
    const refusal = hand.refusal();
    if (refusal !== null) return refusal;
    return numbers().every(Number.isFinite) ? null : "a field is empty";
  };
  /**
   * Until the user starts to type, and again once a target was accepted, the fields show the
   * target that leads the arm, as the arrows do, else the tool.
   */
  let following = true;
  const texts = () => inputs.map((input) => input.value).join();
  const show = () => {
    const pose = hand.pose(context.arm);
    if (pose === null) return;
    const turn = toRpy([pose[3], pose[4], pose[5], pose[6]]);
    const values = [...pose.slice(0, 3).map((v) => v.toFixed(4)), ...turn.map((v) => (v / RAD).toFixed(2))];
    for (const [index, input] of inputs.entries()) input.value = values[index] ?? "";
  };
  const which = () => (context.arm === 0 ? "" : ` --arm ${context.arm}`);
  const limit = () => (hand.contactLimit_n === CONTACT_LIMIT_N ? "" : ` --contact-limit ${hand.contactLimit_n}`);
  const go = button(context, {
    label: "Go",
    // A target that is in force needs no highlighted button.
    primary: () => !following || hand.proposal !== null,
    about: () => "Lead the tool to this target (metres and degrees, world frame)",
    twin: () => {
      const all = numbers();
      return `robocell target ${all.map((v) => (Number.isFinite(v) ? v.toFixed(4) : "?")).join(" ")}${which()} --deg${limit()}`;
    },
    why,
    run: () => {
      const [x = 0, y = 0, z = 0, roll = 0, pitch = 0, yaw = 0] = numbers();
      const pose: Pose = [x, y, z, ...fromRpy(roll * RAD, pitch * RAD, yaw * RAD)];
      const asked = { arm: context.arm, fields: texts() };
      hand.begin();
      return hand.send(asked.arm, pose).then((accepted) => {
        // After a refusal the fields keep their numbers.
        if (accepted && asked.arm === context.arm && asked.fields === texts()) following = true;
      });
    },
  });
  const here = button(context, {
    label: "From robot",
    about: () => "Show where the tool is, until a field is typed into",
    twin: () => null,
    run: () => {
      following = true;
      hand.fromTool(context.arm);
      show();
    },
  });
  const reason = el("p", { class: "dim" });
  const form = el(
    "form",
    { class: "target-form", "aria-label": "Target of the tool" },
    el("h3", {}, "Target of the tool"),
    el("div", { class: "target-fields" }, ...labels),
    el("div", { class: "row" }, here, go, stopAt(context), reason),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    go.click();
  });
  for (const event of ["focusin", "input"]) {
    form.addEventListener(event, ({ target }) => {
      if (target instanceof HTMLInputElement && inputs.includes(target)) following = false;
    });
  }
  context.onArm(() => {
    following = true;
  });
  hand.onChange(() => {
    if (hand.proposal !== null) following = true;
  });
  // Also while it is hidden, so that all fields are filled in when a user starts to type.
  context.pulse.add(null, () => {
    if (following) show();
  });
  context.pulse.add(form, () => setText(reason, why() ?? ""));
  return form;
}

/** The contact force at which the arm stops. */
function stopAt(context: PanelContext): HTMLElement {
  const { hand } = context;
  const attrs = { type: "number", min: 1, max: 1000, step: 5, value: hand.contactLimit_n };
  const input = el("input", { ...attrs, "aria-label": "Contact force at which the arm stops (N)" });
  input.addEventListener("change", () => {
    const value = Number.parseFloat(input.value);
    const isAllowed = value >= 1 && value <= 1000;
    if (isAllowed) hand.contactLimit_n = value;
    else context.notify("a contact force has 1 to 1000 N", true);
    input.value = String(hand.contactLimit_n);
  });
  const title = "The arm stops where it touches something with this force";
  return el("label", { class: "stop-at", title }, "stop at (N)", input);
}
