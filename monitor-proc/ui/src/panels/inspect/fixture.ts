// The card of a fixture.
import type { PanelContext } from "../context";
import { copyPose } from "./copy";
import type { Card } from "./index";
import { poseRows, row, shapeWords } from "./rows";
import { touchRows } from "./touches";

export function fixtureCard(context: PanelContext, index: number): Card | null {
  const spec = context.store.scene?.fixtures[index];
  if (spec === undefined) return null;
  return {
    kind: spec.solid ? "fixture" : "keeps motion away, without a body",
    rows: [
      row("shape", "", () => shapeWords(spec.shape)),
      row("obstacle", "", () => (spec.obstacle === null ? "no" : `yes, number ${spec.obstacle}`)),
      ...poseRows(() => spec.pose),
      row("friction", "", () => spec.friction.toFixed(2)),
      ...(spec.solid ? [touchRows(context, { kind: "fixture", index })] : []),
    ],
    actions: [copyPose(context, () => spec.pose)],
  };
}
