// Pulls an object to a position in numbers.
import type { Vec3 } from "../../net/protocol";
import { button } from "../button";
import type { PanelContext } from "../context";
import { el } from "../dom";
import type { ReadPose } from "./rows";

/** Time that the spring pulls (s), as that of the command. */
const PULL_S = 2;

export function dragForm(context: PanelContext, object: string, read: ReadPose): HTMLElement {
  const inputs = ["x", "y", "z"].map((axis) =>
    el("input", { type: "number", step: 0.01, "aria-label": `${axis} (m)`, title: `${axis} in metres, world frame` }),
  );
  const to = () => inputs.map((input) => Number.parseFloat(input.value)) as Vec3;
  const texts = () => to().map((value) => (Number.isFinite(value) ? value.toFixed(3) : "?"));
  const why = () => {
    const refusal = context.cellRefusal();
    if (refusal !== null) return refusal;
    if (read() === undefined) return `${object} is not in the scene`;
    return to().every(Number.isFinite) ? null : "a field is empty";
  };
  const go = button(context, {
    label: "Drag",
    class: "small",
    about: () => `Pull ${object} to this position (m, world frame) by a spring`,
    twin: () => `robocell drag ${object} --to ${texts().join(" ")}`,
    why,
    run: () => context.send({ do: "drag", object, to: to(), for_s: PULL_S }),
  });
  const label = el("span", { class: "dim" }, "drag to x, y, z (m)");
  const form = el("form", { class: "drag-form", "aria-label": `Drag ${object} to` }, label, ...inputs, go);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    go.click();
  });
  /** The fields show where the object is until one of them is typed into. */
  let follows = true;
  form.addEventListener("input", () => {
    follows = false;
  });
  context.pulse.add(form, () => {
    const pose = read();
    if (!follows || pose === undefined || form.contains(document.activeElement)) return;
    for (const [axis, input] of inputs.entries()) input.value = pose[axis]?.toFixed(4) ?? "";
  });
  return form;
}
