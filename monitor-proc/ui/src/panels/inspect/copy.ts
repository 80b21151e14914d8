// Copies a pose in the notation of cell files.
import type { Pose } from "../../net/protocol";
import { button } from "../button";
import type { Desk } from "../desk";

export function copyPose(desk: Desk, read: () => Pose | undefined): HTMLElement {
  return button(desk, {
    label: "Copy pose",
    class: "small",
    about: () => "Copy position and orientation, as a cell file has them",
    twin: () => null,
    why: () => (read() === undefined ? "no pose" : null),
    run: () => void copy(desk, read()),
  });
}

async function copy(desk: Desk, pose: Pose | undefined): Promise<void> {
  if (pose === undefined) return;
  const numbers = pose.map((value) => value.toFixed(5));
  const text = `position_m = [${numbers.slice(0, 3).join(", ")}]\norientation_wxyz = [${numbers.slice(3).join(", ")}]`;
  try {
    await navigator.clipboard.writeText(text);
    desk.say("Copied the pose");
  } catch {
    desk.say(`the browser refused to copy; the pose: ${text.replace("\n", "; ")}`, true);
  }
}
