// A slider for each joint of the arm: leads it while the task is paused.
import type { ArmSpec, JointSpec } from "../../net/protocol";
import type { ArmState } from "../../net/snapshot";
import { handRefusal } from "../actions";
import type { PanelContext } from "../context";
import { el, setText, setTitle } from "../dom";
import { shortNames } from "../joint-names";
import { LatestOnly } from "./latest-only";

/** Sliders that were let go follow the arm again when it has been at rest so long. */
const LET_GO_MS = 1500;
const REST_RATE = 2e-3;

interface Slider {
  root: HTMLElement;
  input: HTMLInputElement;
  /** The position it asks for (rad, m). */
  wanted: () => number;
  show: (measured: number, setpoint: number, follows: boolean) => void;
}

export function jointForm(context: PanelContext, arm: number, spec: ArmSpec): HTMLElement {
  const own = spec.joints.slice(0, spec.arm_joints);
  const names = shortNames(spec.joints.map(({ name }) => name));
  const sliders = own.map((joint, index) => slider(joint, names[index] ?? joint.name));
  const wanted = () => sliders.map((one) => one.wanted());
  const why = () => context.cellRefusal() ?? handRefusal(context);
  const sender = new LatestOnly(() =>
    context.send({ do: "joints", arm, positions: wanted(), contact_limit_n: context.hand.contactLimit_n }),
  );
  let touchedAt: number | null = null;
  const reason = el("p", { class: "dim" });
  const heads = ["joint", "target", "", "measured", "setpoint"].map((word) => el("span", {}, word));
  const root = el(
    "form",
    { class: "joint-form", "aria-label": "Joint targets" },
    el("h3", {}, "Joint targets"),
    el("div", { class: "joint-slider dim" }, ...heads),
    ...sliders.map((one) => one.root),
    reason,
  );
  root.addEventListener("submit", (event) => event.preventDefault());
  root.addEventListener("input", () => {
    touchedAt = performance.now();
    if (why() === null) sender.ask();
  });
  context.pulse.add(root, () => {
    const state = context.snapshot?.arms[arm];
    const refusal = why();
    setText(reason, refusal ?? "");
    setTitle(root, refusal ?? `$ ${context.onCell(twin(context, arm, wanted()))}`);
    const isIdle =
      touchedAt === null || (performance.now() - touchedAt > LET_GO_MS && state !== undefined && rests(state));
    if (refusal !== null || isIdle) touchedAt = null;
    for (const [index, one] of sliders.entries()) {
      one.input.disabled = refusal !== null;
      one.show(state?.positions[index] ?? 0, state?.setpoints[index] ?? 0, touchedAt === null);
    }
  });
  return root;
}

function rests({ velocities }: ArmState): boolean {
  return velocities.every((rate) => Math.abs(rate) < REST_RATE);
}

function twin(context: PanelContext, arm: number, positions: number[]): string {
  const which = context.store.scene?.arms.length === 1 ? "" : ` --arm ${arm}`;
  return `robocell joints ${positions.map((value) => value.toFixed(3)).join(" ")}${which}`;
}

function slider(joint: JointSpec, short: string): Slider {
  const isLinear = joint.kind === "prismatic";
  const [scale, unit] = isLinear ? [1000, "mm"] : [180 / Math.PI, "°"];
  const [min, max] = [scale * joint.lower, scale * joint.upper];
  const label = `${joint.name} (${isLinear ? "mm" : "degrees"})`;
  const input = el("input", { type: "range", min, max, step: "any", "aria-label": label });
  const text = (value: number) => `${value.toFixed(1)}${isLinear ? " " : ""}${unit}`;
  const target = el("output", { class: "num" });
  const cells = [el("span", { class: "num" }), el("span", { class: "num dim" })] as const;
  const say = () => {
    setText(target, text(Number(input.value)));
    input.setAttribute("aria-valuetext", text(Number(input.value)));
  };
  input.addEventListener("input", say);
  // An arrow key moves by a degree or a millimetre.
  input.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    input.value = String(Number(input.value) + step);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });
  setTitle(input, `${joint.name}: ${text(min)} to ${text(max)}`);
  const name = el("span", { class: "name", title: joint.name }, short);
  return {
    root: el("div", { class: "joint-slider" }, name, input, target, ...cells),
    input,
    wanted: () => Math.min(Math.max(Number(input.value) / scale, joint.lower), joint.upper),
    show(measured, setpoint, follows) {
      setText(cells[0], text(scale * measured));
      setText(cells[1], text(scale * setpoint));
      if (!follows) return;
      input.value = String(scale * setpoint);
      say();
    },
  };
}
