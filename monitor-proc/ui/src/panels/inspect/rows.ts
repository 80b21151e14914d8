// Rows of a name and a value that follow the snapshot.
import type { Pose, Shape, Vec3 } from "../../net/protocol";
import { el, setText } from "../dom";
import { toRpy } from "../robot/rotation";

const DEG = 180 / Math.PI;

export interface Row {
  node: HTMLElement;
  show: () => void;
}

/** Reads where something is; undefined while it is not in the scene. */
export type ReadPose = () => Pose | undefined;

/** A row called `name`, with its unit, that shows what `read` gives. */
export function row(name: string, unit: string, read: () => string): Row {
  const value = el("b", { class: "num" }, "–");
  const label = el("span", { class: "dim" }, unit === "" ? name : `${name} (${unit})`);
  const node = el("div", { class: "fact wide", "data-row": name }, label, value);
  return { node, show: () => setText(value, read()) };
}

/** Numbers side by side; what rounds to zero has no sign. */
export function list(values: readonly number[], digits: number): string {
  return values.map((value) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1")).join(", ");
}

/** Three rows of a pose; `whose` is put before the position. */
export function poseRows(read: ReadPose, whose = ""): Row[] {
  const of = (name: string, unit: string, text: (pose: Pose) => string) =>
    row(name, unit, () => {
      const pose = read();
      return pose === undefined ? "–" : text(pose);
    });
  return [
    of(`${whose}position`, "m", (pose) => list(pose.slice(0, 3), 4)),
    of("roll, pitch, yaw", "°", (pose) => list(anglesOf(pose), 2)),
    of("w, x, y, z", "", (pose) => list(pose.slice(3), 4)),
  ];
}

/** Roll, pitch and yaw (degrees). */
export function anglesOf([, , , w, x, y, z]: Pose): Vec3 {
  return toRpy([w, x, y, z]).map((angle) => angle * DEG) as Vec3;
}

function size(metres: number): string {
  return (1000 * metres).toFixed(0);
}

/** A shape with its size. */
export function shapeWords(shape: Shape): string {
  switch (shape.kind) {
    case "box":
    case "bin":
      return `${shape.kind} ${shape.size_m.map(size).join(" × ")} mm`;
    case "sphere":
      return `sphere, radius ${size(shape.radius_m)} mm`;
    case "cylinder":
    case "capsule":
      return `${shape.kind}, radius ${size(shape.radius_m)}, length ${size(shape.length_m)} mm`;
    case "compound":
      return `${shape.parts.length} shapes`;
  }
}
