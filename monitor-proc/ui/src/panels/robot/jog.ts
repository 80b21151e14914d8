// Sliders that lead the joints of an arm while the task is paused.
import type { ArmSpec } from "../../net/protocol";
import { handRefusal } from "../actions";
import type { Desk } from "../desk";
import { el, setText, setTitle } from "../dom";

const SENDS_A_SECOND = 10;

export interface Jogger {
  slider(joint: number, name: string): HTMLElement;
  /** Why they cannot be used now. */
  readonly reason: HTMLElement;
}

export function jogger(desk: Desk, arm: number, spec: ArmSpec): Jogger {
  const inputs: HTMLInputElement[] = [];
  const reason = el("p", { class: "dim hint" });
  const why = () => desk.cellRefusal() ?? handRefusal(desk);
  const positions = () => inputs.map((input) => Number(input.value));
  let waiting = false;
  let again = false;
  const send = () => {
    if (waiting) {
      again = true;
      return;
    }
    waiting = true;
    again = false;
    void desk.send({ do: "joints", arm, positions: positions() });
    setTimeout(() => {
      waiting = false;
      if (again) send();
    }, 1000 / SENDS_A_SECOND);
  };
  /** The sliders follow the robot until one is moved. */
  let moved = false;
  desk.pulse.add(reason, () => {
    const refusal = why();
    const state = desk.snapshot?.arms[arm];
    if (refusal !== null) moved = false;
    for (const [joint, input] of inputs.entries()) {
      input.hidden = refusal !== null;
      const twin = `robocell joints ${positions().map((q) => q.toFixed(3)).join(" ")}${arm === 0 ? "" : ` --arm ${arm}`}`;
      setTitle(input, refusal === null ? `Lead this joint\n$ ${desk.onCell(twin)}` : "");
      if (!moved && state !== undefined) input.value = String(state.positions[joint] ?? 0);
    }
    setText(reason, refusal === null ? "Move a slider to lead a joint." : `Joint sliders: ${refusal}.`);
  });
  return {
    reason,
    slider(joint, name) {
      const limits = spec.joints[joint];
      const input = el("input", {
        type: "range",
        class: "jog",
        min: limits?.lower ?? -Math.PI,
        max: limits?.upper ?? Math.PI,
        step: 0.001,
        hidden: true,
        "aria-label": `Lead joint ${name} (${limits?.kind === "prismatic" ? "m" : "rad"})`,
      });
      inputs[joint] = input;
      input.addEventListener("input", () => {
        moved = true;
        send();
      });
      return input;
    },
  };
}
