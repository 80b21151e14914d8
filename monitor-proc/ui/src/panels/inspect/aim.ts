// Brings the tool of the arm that is led over an object, and down to its grasp.
import { above, angleBetween, poseOf, rotationOf } from "../../hand/aims";
import type { Pose } from "../../net/protocol";
import { Vector3 } from "three";
import { button } from "../button";
import type { PanelContext } from "../context";

/** The tool descends where it is nearer to the axis of the grasp than this (m). */
const ALIGNED_M = 0.03;

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
  const spec = context.store.scene?.objects[index];
  const why = () => hand.refusal() ?? (read() === undefined ? `${name} is not in the scene` : null);
  const gripper = () => context.store.scene?.arms[context.arm]?.gripper ?? null;
  let searches = false;
  return [
    button(context, {
      label: "Above",
      class: "small",
      about: () => `Bring the tool of ${context.armName(context.arm)} 100 mm above ${name}: pointing down, turned along its sides`,
      twin: () => null,
      why,
      run: () => {
        const [tool, pose] = [hand.pose(context.arm), read()];
        if (tool === null || pose === undefined || spec === undefined) return;
        hand.begin();
        hand.move(context.arm, above(tool, gripper(), spec.shape, pose));
      },
    }),
    button(context, {
      label: "Approach",
      class: "small",
      about: () => `Bring the tool of ${context.armName(context.arm)} from above ${name} down to its grasp`,
      twin: () => null,
      why: () => why() ?? (searches ? "it searches" : null),
      run: async () => {
        searches = true;
        await approach(context, name, index).catch(() => context.notify("the answer about grasps is broken", true));
        searches = false;
      },
    }),
  ];
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
