// A transparent robot at the target that waits for Go.
import { Group, MeshLambertMaterial, Vector3 } from "three";
import type { Hand } from "../../hand/hand";
import type { Pose } from "../../net/protocol";
import type { Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import { Robot } from "../robots/robot";

const COLOUR = 0xffd166;
/** Where the arm would be is asked for at most so often. */
const PERIOD_MS = 100;

export class ProposalGhost {
  readonly root = new Group();
  private robot: Robot | null = null;
  private arm = -1;
  private asked = "";
  private answered = "";
  private joints: number[] | null = null;
  private busy = false;
  private readonly paint = new MeshLambertMaterial({
    color: COLOUR,
    emissive: 0x5a4410,
    transparent: true,
    opacity: 0.35,
    depthWrite: false,
  });

  constructor(
    private readonly hand: Hand,
    private readonly changed: () => void,
  ) {}

  reset(): void {
    this.root.clear();
    [this.robot, this.arm, this.joints, this.answered] = [null, -1, null, ""];
  }

  update(cell: Cell, snapshot: Snapshot, labels: Labels): void {
    const { proposal } = this.hand;
    this.root.visible = false;
    if (proposal === null) return;
    const spec = cell.scene.arms[proposal.arm];
    const state = snapshot.arms[proposal.arm];
    if (spec === undefined || state === undefined) return;
    if (this.arm !== proposal.arm) {
      this.reset();
      this.robot = new Robot(spec, () => {}, this.paint);
      this.robot.root.traverse((object) => {
        object.raycast = () => {};
      });
      this.root.add(this.robot.root);
      this.arm = proposal.arm;
    }
    this.ask(proposal.arm, proposal.pose);
    const at = new Vector3(...proposal.pose.slice(0, 3));
    const isKnown = this.answered !== "";
    if (this.joints === null) {
      if (isKnown) labels.show("proposal", "out of reach", at, "number");
      return;
    }
    // The fingers stay as they are.
    const all = [...state.positions];
    all.splice(0, this.joints.length, ...this.joints);
    this.robot?.setJoints(all);
    this.root.visible = true;
    labels.show("proposal", "Go (Enter) moves the arm here", at);
  }

  private ask(arm: number, pose: Pose): void {
    this.asked = `/api/joints/${arm}/${pose.map((value) => value.toFixed(5)).join()}`;
    if (!this.busy && this.asked !== this.answered) void this.fetch(this.asked);
  }

  private async fetch(url: string): Promise<void> {
    this.busy = true;
    const pause = new Promise((done) => setTimeout(done, PERIOD_MS));
    const [answer] = await Promise.all([fetch(url).catch(() => null), pause]);
    this.busy = false;
    // A search of another page is waited for.
    if (answer?.ok === true) {
      const { joints } = (await answer.json()) as { joints: number[] | null };
      [this.joints, this.answered] = [joints, url];
    }
    this.changed();
  }
}
