// Each joint between its limits: where it is, where it should be, how hard it
// works, and whether the controller had to clip it.
import type { ArmSpec, JointSpec } from "../../net/protocol";
import type { ArmState } from "../../net/snapshot";
import type { PanelContext } from "../context";
import { el, setAttr, setText, setTitle } from "../dom";
import { shortNames } from "../joint-names";
import { term } from "../terms";

/** Shares of the range, from a limit, that are near and very near. */
const NEAR = 0.1;
const VERY_NEAR = 0.03;
/** A clip of one cycle would not be seen. */
const CLIP_SHOWN_MS = 600;

export function joints(context: PanelContext, arm: number, spec: ArmSpec): HTMLElement {
  const names = shortNames(spec.joints.map(({ name }) => name));
  const rows = spec.joints.map((joint, index) =>
    jointRow(joint, names[index] ?? joint.name, index, index < spec.arm_joints),
  );
  const head = el(
    "div",
    { class: "joint joint-head dim" },
    el("span", {}, "joint"),
    el("span", {}, "limits"),
    el("span", { class: "num" }, term("measured")),
    el("span", { class: "num" }, term("error")),
    el("span", {}, term("effort")),
  );
  const root = el("div", { class: "joints" }, head, ...rows.map((row) => row.root));
  context.pulse.add(root, () => {
    const state = context.snapshot?.arms[arm];
    if (!state) return;
    for (const row of rows) row.show(state);
  });
  return root;
}

/** `careful`: being near a limit means something; fingers rest at theirs. */
function jointRow(joint: JointSpec, short: string, index: number, careful: boolean) {
  const needle = el("i", { class: "needle" });
  const wanted = el("i", { class: "wanted" });
  const track = el("div", { class: "track" }, wanted, needle);
  const value = el("span", { class: "num" });
  const error = el("span", { class: "num dim" });
  const effort = el("i", {});
  const clip = el("span", { class: "clip", title: "The acceleration was clipped to the joint's limit" }, "CLIP");
  const unit = joint.kind === "prismatic" ? " mm" : "°";
  const scale = joint.kind === "prismatic" ? 1000 : 180 / Math.PI;
  const range = joint.upper - joint.lower;
  const bounded = Number.isFinite(range) && range > 0;
  let clipped = -CLIP_SHOWN_MS;
  const share = (q: number) => Math.min(Math.max((q - joint.lower) / range, 0), 1);
  const root = el(
    "div",
    { class: "joint" },
    el("span", { class: "name", title: joint.name }, short, clip),
    track,
    value,
    error,
    el("div", { class: "track effort" }, effort),
  );
  const show = (state: ArmState) => {
    const q = state.positions[index] ?? 0;
    const setpoint = state.setpoints[index] ?? q;
    setText(value, `${(scale * q).toFixed(1)}${unit}`);
    setText(error, `${(scale * (q - setpoint)).toFixed(joint.kind === "prismatic" ? 1 : 2)}${unit}`);
    if (bounded) {
      const at = share(q);
      needle.style.left = `${100 * at}%`;
      wanted.style.left = `${100 * share(setpoint)}%`;
      const left = Math.min(at, 1 - at);
      setAttr(root, "data-near", !careful ? null : left < VERY_NEAR ? "very" : left < NEAR ? "near" : null);
      const nearest = Math.min(q - joint.lower, joint.upper - q);
      setTitle(
        track,
        `${(scale * joint.lower).toFixed(0)} to ${(scale * joint.upper).toFixed(0)}${unit}; ${(scale * nearest).toFixed(1)}${unit} to the nearer limit; setpoint ${(scale * setpoint).toFixed(2)}${unit}`,
      );
    }
    const drive = state.efforts[index] ?? 0;
    const part = joint.effort > 0 ? Math.min(Math.abs(drive) / joint.effort, 1) : 0;
    effort.style.width = `${50 * part}%`;
    effort.style.left = drive < 0 ? `${50 - 50 * part}%` : "50%";
    setAttr(effort, "data-near", part > 0.9 ? "very" : part > 0.7 ? "near" : null);
    setTitle(effort, `${drive.toFixed(1)} of ${joint.effort.toFixed(0)} ${joint.kind === "prismatic" ? "N" : "N m"}`);
    const now = performance.now();
    if ((state.clipped & (1 << index)) !== 0) clipped = now;
    clip.classList.toggle("on", now - clipped < CLIP_SHOWN_MS);
  };
  return { root, show };
}
