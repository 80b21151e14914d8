// The card of an object.
import { norm } from "../../net/contacts";
import type { Vec3 } from "../../net/protocol";
import { OBJECT, type ObjectState } from "../../net/snapshot";
import type { PanelContext } from "../context";
import { aimButtons } from "./aim";
import { copyPose } from "./copy";
import { dragForm } from "./drag-form";
import { graspList } from "./grasps";
import type { Card } from "./index";
import { list, poseRows, row, shapeWords } from "./rows";
import { touchRows } from "./touches";

const DEG = 180 / Math.PI;
/** Slower than this is at rest. */
const STILL_M_S = 2e-3;
const STILL_RAD_S = 2e-2;

export function objectCard(context: PanelContext, index: number): Card | null {
  const spec = context.store.scene?.objects[index];
  if (spec === undefined) return null;
  const state = () => context.snapshot?.objects[index];
  const isHere = () => ((state()?.flags ?? 0) & OBJECT.enabled) !== 0;
  const pose = () => (isHere() ? state()?.pose : undefined);
  const holder = () => context.snapshot?.arms.findIndex((arm) => arm.held === index) ?? -1;
  const here = (read: (found: ObjectState) => string) => () => {
    const found = state();
    return found === undefined || !isHere() ? "–" : read(found);
  };
  const velocity = here(({ linear }) => list(linear, 3));
  const turns = (rates: Vec3) => rates.map((rate) => rate * DEG);
  const turnRate = here(({ angular }) => list(turns(angular), 1));
  const absent = () => {
    if (spec.parked !== true) return "lost: it fell out of the cell";
    return context.store.isTaskOver ? "not used" : "to come: a device brings it";
  };
  return {
    kind: spec.kind === spec.name ? "object" : `object of the series ${spec.kind}`,
    rows: [
      row("shape", "", () => shapeWords(spec.shape)),
      row("state", "", () => stateWords(state(), absent())),
      row("held by", "", () => (holder() < 0 ? "no arm" : context.armName(holder()))),
      ...poseRows(pose),
      row("velocity", "m/s", velocity),
      row("turn rate", "°/s", turnRate),
      row("mass", "kg", () => spec.mass_kg.toFixed(3)),
      row("friction", "", () => spec.friction.toFixed(2)),
      touchRows(context, { kind: "object", index }),
    ],
    actions: [
      ...aimButtons(context, spec.name, index, pose),
      dragForm(context, spec.name, pose),
      copyPose(context, pose),
      ...graspList(context, spec.name, index, pose),
    ],
  };
}

function stateWords(state: ObjectState | undefined, absent: string): string {
  if (state === undefined) return "not in the scene";
  if ((state.flags & OBJECT.enabled) === 0) return absent;
  if ((state.flags & OBJECT.dragged) !== 0) return "dragged";
  return isAtRest(state) ? "at rest" : "moves";
}

/** Whether an object stays where it is, with contacts that physics computes or without. */
export function isAtRest({ linear, angular, flags }: ObjectState): boolean {
  return (norm(linear) < STILL_M_S && norm(angular) < STILL_RAD_S) || (flags & OBJECT.asleep) !== 0;
}
