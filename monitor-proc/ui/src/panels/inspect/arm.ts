// The card of an arm: the Robot tab has the rest.
import type { Desk } from "../desk";
import { button } from "../button";
import { openDrawer } from "../drawers";
import { stopWords } from "../stop-words";
import { copyPose } from "./copy";
import type { Card } from "./index";
import { list, poseRows, row } from "./rows";
import { touchRows } from "./touches";

export function armCard(desk: Desk, index: number): Card | null {
  const spec = desk.store.scene?.arms[index];
  if (spec === undefined) return null;
  const state = () => desk.snapshot?.arms[index];
  const tcp = () => state()?.tcp;
  const held = () => {
    const object = state()?.held ?? null;
    return object === null ? "nothing" : (desk.store.scene?.objects[object]?.name ?? "?");
  };
  const robot = button(desk, {
    label: "Robot tab",
    class: "small",
    about: () => "Show joints, target and gripper of this arm in the Robot tab",
    twin: () => null,
    run: () => {
      desk.openTab("robot");
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
      touchRows(desk, { kind: "arm", index }),
    ],
    actions: [robot, copyPose(desk, tcp)],
  };
}
