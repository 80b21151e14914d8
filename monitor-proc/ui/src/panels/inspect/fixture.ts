// The card of a fixture.
import type { Desk } from "../desk";
import { copyPose } from "./copy";
import type { Card } from "./index";
import { poseRows, row, shapeWords } from "./rows";
import { touchRows } from "./touches";

export function fixtureCard(desk: Desk, index: number): Card | null {
  const spec = desk.store.scene?.fixtures[index];
  if (spec === undefined) return null;
  return {
    kind: spec.solid ? "fixture" : "keeps motion away, without a body",
    rows: [
      row("shape", "", () => shapeWords(spec.shape)),
      row("obstacle", "", () => (spec.obstacle === null ? "no" : `yes, number ${spec.obstacle}`)),
      ...poseRows(() => spec.pose),
      row("friction", "", () => spec.friction.toFixed(2)),
      ...(spec.solid ? [touchRows(desk, { kind: "fixture", index })] : []),
    ],
    actions: [copyPose(desk, () => spec.pose)],
  };
}
