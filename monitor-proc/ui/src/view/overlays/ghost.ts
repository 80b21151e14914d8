// A second, transparent robot in the pose that the controller wants of the first.
import { Group, MeshLambertMaterial } from "three";
import type { Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import { Robot } from "../robots/robot";
import type { Overlay } from "./overlay";

export class Ghost implements Overlay {
  readonly name = "ghost";
  readonly root = new Group();
  private robots: Robot[] | null = null;
  private readonly paint = new MeshLambertMaterial({
    color: 0x38c6ff,
    emissive: 0x0b4a66,
    transparent: true,
    opacity: 0.32,
    depthWrite: false,
  });

  update(cell: Cell, snapshot: Snapshot): void {
    this.robots ??= this.make(cell);
    for (const robot of this.robots) {
      const arm = snapshot.arms[cell.scene.arms.indexOf(robot.spec)];
      if (arm !== undefined) robot.setJoints(arm.setpoints);
    }
  }

  reset(): void {
    this.root.clear();
    this.robots = null;
  }

  private make(cell: Cell): Robot[] {
    const robots = cell.robots.map(({ spec }) => new Robot(spec, () => {}, this.paint));
    for (const robot of robots) this.root.add(robot.root);
    this.root.traverse((object) => {
      object.raycast = () => {};
    });
    return robots;
  }
}
