// Copies a pose in the notation of cell files.
import type { Pose } from "../../net/protocol";
import { button } from "../button";
import type { PanelContext } from "../context";
import type { ReadPose } from "./rows";

export function copyPose(context: PanelContext, read: ReadPose): HTMLElement {
  return button(context, {
    label: "Copy pose",
    class: "small",
    about: () => "Copy position and orientation, as a cell file has them",
    twin: () => null,
    why: () => (read() === undefined ? "no pose" : null),
    run: () => void copy(context, read()),
  });
}

async function copy(context: PanelContext, pose: Pose | undefined): Promise<void> {
  if (pose === undefined) return;
  const numbers = pose.map((value) => value.toFixed(5));
  const text = `position_m = [${numbers.slice(0, 3).join(", ")}]\norientation_wxyz = [${numbers.slice(3).join(", ")}]`;
  try {
    await navigator.clipboard.writeText(text);
    context.notify("Copied the pose");
  } catch {
    context.notify(`the browser refused to copy; the pose: ${text.replace("\n", "; ")}`, true);
  }
}
