// The card of an arm: the Robot tab has the rest.
import { button } from "../button";
import type { PanelContext } from "../context";
import { openDrawer } from "../drawers";
import { stopWords } from "../stop-words";
import { copyPose } from "./copy";
import type { Card } from "./index";
import { list, poseRows, row } from "./rows";
import { touchRows } from "./touches";

export function armCard(context: PanelContext, index: number): Card | null {
  const spec = context.store.scene?.arms[index];
  if (spec === undefined) return null;
  const state = () => context.snapshot?.arms[index];
  const tcp = () => state()?.tcp;
  const held = () => {
    const object = state()?.held ?? null;
    return object === null ? "nothing" : (context.store.scene?.objects[object]?.name ?? "?");
  };
  const robot = button(context, {
    label: "Robot tab",
    class: "small",
    about: () => "Show joints, target and gripper of this arm in the Robot tab",
    twin: () => null,
    run: () => {
      context.openTab("robot");
      openDrawer("right");
    },
  });
  return {
    kind: `arm, ${spec.robot}`,
    rows: [
      row("controller", "", () => stopWords(state()?.controllerStop ?? 0).name),
      row("holds", "", held),
      row("base", "m", () => list(spec.base.position, 3)),
      ...poseRows(tcp, "TCP "),
      touchRows(context, { kind: "arm", index }),
    ],
    actions: [robot, copyPose(context, tcp)],
  };
}
