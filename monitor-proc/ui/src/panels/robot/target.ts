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
  /** The fields show where the tool is until the user starts to type. */
  let following = true;
  const measured = () => {
    const tcp = context.snapshot?.arms[context.arm]?.tcp;
    if (tcp === undefined) return;
    const turn = toRpy([tcp[3], tcp[4], tcp[5], tcp[6]]);
    const values = [...tcp.slice(0, 3).map((v) => v.toFixed(3)), ...turn.map((v) => (v / RAD).toFixed(1))];
    for (const [index, input] of inputs.entries()) input.value = values[index] ?? "";
  };
  const which = () => (context.arm === 0 ? "" : ` --arm ${context.arm}`);
  const go = button(context, {
    label: "Go",
    class: "primary",
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
      return context.send({ do: "target", arm: context.arm, position, orientation_wxyz: turn });
    },
  });
  const here = button(context, {
    label: "From robot",
    about: () => "Show where the tool is, until a field is typed into",
    twin: () => null,
    run: () => {
      following = true;
      measured();
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
  form.addEventListener("focusin", ({ target }) => {
    if (target instanceof HTMLInputElement) following = false;
  });
  context.onArm(() => {
    following = true;
  });
  // Hidden, too: a user who starts to type finds all fields filled in.
  context.pulse.add(null, () => {
    if (following) measured();
  });
  context.pulse.add(form, () => setText(reason, why() ?? ""));
  return form;
}
