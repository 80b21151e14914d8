// Brings the tool of the arm that is led, or the object in it, over another object, and down to it.
import { above, ABOVE_M, angleBetween, over, type Placed, poseOf, rotationOf } from "../../hand/aims";
import type { Pose } from "../../net/protocol";
import { Vector3 } from "three";
import { button } from "../button";
import type { PanelContext } from "../context";

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

export function aimButtons(context: PanelContext, name: string, index: number, read: () => Pose | undefined): HTMLElement[] {
  const { hand } = context;
  const arm = () => context.armName(context.arm);
  const why = () => hand.refusal() ?? (read() === undefined ? `${name} is not in the scene` : heldBy(context) === index ? `${arm()} holds it` : null);
  const held = () => context.store.scene?.objects[heldBy(context) ?? -1]?.name ?? null;
  let searches = false;
  return [
    button(context, {
      label: "Above",
      class: "small",
      about: () => (held() === null ? `Bring the tool of ${arm()} 100 mm above ${name}: pointing down, turned along its sides` : `Bring ${held()} 100 mm above ${name}`),
      twin: () => null,
      why,
      run: () => bringAbove(context, index),
    }),
    button(context, {
      label: "Approach",
      class: "small",
      name: () => (held() === null ? "Approach" : "Place"),
      about: () => (held() === null ? `Bring the tool of ${arm()} from above ${name} down to its grasp` : `Bring ${held()} from above ${name} down onto it; the gripper stays closed`),
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

function bringAbove(context: PanelContext, index: number): void {
  const { hand, arm } = context;
  const [tool, object, held] = [hand.pose(arm), placed(context, index), placed(context, heldBy(context))];
  if (tool === null || object === null) return;
  hand.begin();
  const gripper = context.store.scene?.arms[arm]?.gripper ?? null;
  hand.move(arm, held === null ? above(tool, gripper, object.shape, object.pose) : over(tool, held, object, ABOVE_M));
}

function bringDown(context: PanelContext, name: string, index: number): void {
  const { hand, arm } = context;
  const [tool, object, held] = [hand.pose(arm), placed(context, index), placed(context, heldBy(context))];
  if (tool === null || object === null || held === null) return;
  const goal = over(tool, held, object, GAP_M);
  const offset = new Vector3(goal[0] - tool[0], goal[1] - tool[1], 0).length();
  if (offset > ALIGNED_M || goal[2] > tool[2]) {
    context.notify(`what the arm holds is ${(1000 * offset).toFixed(0)} mm beside ${name}: press Above first`, true);
    return;
  }
  hand.begin();
  hand.move(arm, goal);
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
  const poses = candidates.filter(({ excluded }) => excluded === null).map(({ tcp }): Pose => [...tcp.position, ...tcp.orientation_wxyz]);
  // The better of two that need the same turn comes first.
  const turn = (pose: Pose) => Math.round(10 * angleBetween(tool, pose));
  const best = poses.reduce<Pose | null>((one, other) => (one === null || turn(other) < turn(one) ? other : one), null);
  if (best === null) {
    context.notify(`${name} cannot be gripped: ${message ?? "there is no grasp"}`, true);
    return;
  }
  const offset = new Vector3(tool[0] - best[0], tool[1] - best[1], 0).length();
  if (offset > ALIGNED_M || tool[2] < best[2]) {
    context.notify(`the tool is ${(1000 * offset).toFixed(0)} mm beside ${name}: press Above first`, true);
    return;
  }
  hand.begin();
  hand.move(arm, poseOf(new Vector3(best[0], best[1], best[2]), rotationOf(best)));
}
