// What can be plotted: numbers of snapshots and of status, by name.
import type { Scene, Status } from "../../net/protocol";
import type { Snapshot } from "../../net/snapshot";
import { css } from "../format";
import { shortNames } from "../joint-names";

const DEG = 180 / Math.PI;

export interface Signal {
  /** Stable name, as in the URL. */
  key: string;
  group: string;
  name: string;
  unit: string;
  /** Of the object it is about, where it has one of its own. */
  colour?: string;
  /** Its value now; NaN where there is none. */
  read: (snapshot: Snapshot, status: Status | null) => number;
}

export function signalsOf(scene: Scene | null, hops: Status["latency"]): Signal[] {
  const all: Signal[] = [];
  const add = (group: string, name: string, unit: string, read: Signal["read"]) =>
    all.push({ key: `${group}/${name}`, group, name, unit, read });
  if (scene !== null) for (const arm of scene.arms.keys()) addArm(scene, arm, add);
  const colours = scene?.objects.map(({ colour }) => css(colour)) ?? [];
  scene?.objects.forEach((object, index) => {
    add("objects", `${object.name} z`, "m", (s) => s.objects[index]?.pose[2] ?? NaN);
    const colour = colours[index];
    // Lines of one colour could not be told apart.
    if (colour !== undefined && colours.filter((one) => one === colour).length === 1)
      Object.assign(all.at(-1) ?? {}, { colour });
  });
  add("run", "real-time factor", "", (s) => s.realTimeFactor);
  add("run", "decision age", "ms", (_, status) => status?.task.decision_age_ms ?? NaN);
  for (const { hop, arm } of hops) {
    const name = arm === null ? hop : `${hop}, ${scene?.arms[arm]?.name ?? arm}`;
    add("latency", `${name} p99`, "µs", (_, status) => {
      return status?.latency.find((one) => one.hop === hop && one.arm === arm)?.p99_us ?? NaN;
    });
  }
  return all;
}

function addArm(
  scene: Scene,
  arm: number,
  add: (group: string, name: string, unit: string, read: Signal["read"]) => void,
): void {
  const spec = scene.arms[arm];
  if (spec === undefined) return;
  const { name: group } = spec;
  add(group, "distance to target", "mm", (s) => {
    const state = s.arms[arm];
    return state?.targetValid === true ? 1000 * state.positionError : NaN;
  });
  add(group, "clearance", "mm", (s) => {
    const clearance = s.arms[arm]?.clearance ?? NaN;
    return clearance > 999 ? NaN : 1000 * clearance;
  });
  for (const [axis, name] of ["x", "y", "z"].entries()) {
    add(group, `TCP ${name}`, "m", (s) => s.arms[arm]?.tcp[axis] ?? NaN);
  }
  if (spec.gripper?.kind === "suction") {
    add(group, "suction load", "%", (s) => 100 * (s.arms[arm]?.load ?? NaN));
    const cup = (status: Status | null) => status?.equipment?.suction[arm];
    add(group, "suction force", "N", (_, status) => cup(status)?.force_n ?? NaN);
    add(group, "suction torque", "N m", (_, status) => cup(status)?.torque_n_m ?? NaN);
  } else if (spec.gripper !== null) {
    add(group, "gripper width", "mm", (s) => 1000 * (s.arms[arm]?.width ?? NaN));
    add(group, "grip force", "N", (s) => s.arms[arm]?.force ?? NaN);
  }
  const names = shortNames(spec.joints.map(({ name }) => name));
  for (const [joint, { name, kind }] of spec.joints.entries()) {
    const linear = kind === "prismatic";
    const [scale, unit] = linear ? [1000, "mm"] : [DEG, "°"];
    const short = names[joint] ?? name;
    add(group, `${short} position`, unit, (s) => scale * (s.arms[arm]?.positions[joint] ?? NaN));
    add(group, `${short} setpoint`, unit, (s) => scale * (s.arms[arm]?.setpoints[joint] ?? NaN));
    add(group, `${short} error`, unit, (s) => {
      const state = s.arms[arm];
      return scale * ((state?.positions[joint] ?? NaN) - (state?.setpoints[joint] ?? NaN));
    });
    add(group, `${short} velocity`, `${unit}/s`, (s) => scale * (s.arms[arm]?.velocities[joint] ?? NaN));
    add(group, `${short} effort`, linear ? "N" : "N m", (s) => s.arms[arm]?.efforts[joint] ?? NaN);
  }
}
