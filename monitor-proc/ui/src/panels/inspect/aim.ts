// Brings the tool of the arm that is led, or the object in it, over another object, and down to it.
import { Vector3 } from "three";
import { ABOVE_M, above, angleBetween, over, type Placed, poseOf, rotationOf } from "../../hand/aims";
import type { Pose } from "../../net/protocol";
import { button } from "../button";
import type { PanelContext } from "../context";
import type { ReadPose } from "./rows";

/** The tool descends where it is nearer to the axis of the grasp than this (m). */
const ALIGNED_M = 0.03;
/** An object is placed this far above the one below it: the arm does not press (m). */
const GAP_M = 0.001;

interface Candidate {
  tcp: { position: [number, number, number]; orientation_wxyz: [number, number, number, number] };
  excluded: string | null;
}

interface Grasps {
  candidates: Candidate[];
  message: string | null;
}

export function aimButtons(context: PanelContext, name: string, index: number, read: ReadPose): HTMLElement[] {
  const { hand } = context;
  const arm = () => context.armName(context.arm);
  const why = () => {
    const absent = read() === undefined ? `${name} is not in the scene` : null;
    return hand.refusal() ?? absent ?? (heldBy(context) === index ? `${arm()} holds it` : null);
  };
  const held = () => context.store.scene?.objects[heldBy(context) ?? -1]?.name ?? null;
  let searches = false;
  return [
    button(context, {
      label: "Above",
      class: "small",
      about: () => {
        if (held() !== null) return `Bring ${held()} 100 mm above ${name}`;
        return `Bring the tool of ${arm()} 100 mm above ${name}: pointing down, turned along its sides`;
      },
      twin: () => null,
      why,
      run: () => bringAbove(context, index),
    }),
    button(context, {
      label: "Approach",
      class: "small",
      name: () => (held() === null ? "Approach" : "Place"),
      about: () => {
        if (held() === null) return `Bring the tool of ${arm()} from above ${name} down to its grasp`;
        return `Bring ${held()} from above ${name} down onto it; the gripper stays closed`;
      },
      twin: () => null,
      why: () => why() ?? (searches ? "it searches" : null),
      run: async () => {
        if (held() !== null) return bringDown(context, name, index);
        searches = true;
        await approach(context, name, index).catch(() => context.notify("the answer about grasps is broken", true));
        searches = false;
      },
    }),
  ];
}

/** The object that the arm that is led holds, by its place in the scene. */
function heldBy({ snapshot, arm }: PanelContext): number | null {
  return snapshot?.arms[arm]?.held ?? null;
}

function placed({ store, snapshot }: PanelContext, index: number | null): Placed | null {
  const [shape, pose] = [store.scene?.objects[index ?? -1]?.shape, snapshot?.objects[index ?? -1]?.pose];
  return shape === undefined || pose === undefined ? null : { shape, pose };
}

/** Of the tool, of the object `index` and of the one that is held. */
function posesFor(context: PanelContext, index: number) {
  const { hand, arm } = context;
  return [hand.pose(arm), placed(context, index), placed(context, heldBy(context))] as const;
}

function bringAbove(context: PanelContext, index: number): void {
  const { hand, arm } = context;
  const [tool, object, held] = posesFor(context, index);
  if (tool === null || object === null) return;
  hand.begin();
  const gripper = context.store.scene?.arms[arm]?.gripper ?? null;
  hand.move(arm, held === null ? above(tool, gripper, object.shape, object.pose) : over(tool, held, object, ABOVE_M));
}

function bringDown(context: PanelContext, name: string, index: number): void {
  const [tool, object, held] = posesFor(context, index);
  if (tool === null || object === null || held === null) return;
  descend(context, tool, over(tool, held, object, GAP_M), "what the arm holds", name);
}

/** Leads the tool down to `goal`, if it is above it. */
function descend(context: PanelContext, tool: Pose, goal: Pose, what: string, name: string): void {
  const offset = Math.hypot(goal[0] - tool[0], goal[1] - tool[1]);
  if (offset > ALIGNED_M || goal[2] > tool[2]) {
    context.notify(`${what} is ${(1000 * offset).toFixed(0)} mm beside ${name}: press Above first`, true);
    return;
  }
  context.hand.begin();
  context.hand.move(context.arm, goal);
}

async function approach(context: PanelContext, name: string, object: number): Promise<void> {
  const { hand, arm } = context;
  const answer = await fetch(`/api/grasps/${arm}/${object}`).catch(() => null);
  const tool = hand.pose(arm);
  if (answer?.ok !== true || tool === null) {
    context.notify(answer === null ? "the monitor does not answer" : (await answer.text()).trim(), true);
    return;
  }
  const { candidates, message } = (await answer.json()) as Grasps;
  const free = candidates.filter(({ excluded }) => excluded === null);
  const poses = free.map(({ tcp }): Pose => [...tcp.position, ...tcp.orientation_wxyz]);
  // The better of two that need the same turn comes first.
  const turn = (pose: Pose) => Math.round(10 * angleBetween(tool, pose));
  const best = poses.reduce<Pose | null>((one, other) => (one === null || turn(other) < turn(one) ? other : one), null);
  if (best === null) {
    context.notify(`${name} cannot be gripped: ${message ?? "there is no grasp"}`, true);
    return;
  }
  const goal = poseOf(new Vector3(best[0], best[1], best[2]), rotationOf(best));
  descend(context, tool, goal, "the tool", name);
}
