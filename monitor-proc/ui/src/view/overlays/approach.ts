// The way a tool comes to its target: a funnel along the tool's own z axis.
import { ConeGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial } from "three";
import type { Snapshot } from "../../net/snapshot";
import { place } from "../body";
import type { Cell } from "../cell";
import type { Overlay } from "./overlay";

const LENGTH_M = 0.16;
const WIDE_M = 0.055;

export class Approach implements Overlay {
  readonly name = "approach";
  readonly root = new Group();
  private readonly funnels: Mesh[] = [];
  private readonly shape = new ConeGeometry(WIDE_M, LENGTH_M, 24, 1, true);
  private readonly paint = new MeshBasicMaterial({
    color: 0xffd166,
    transparent: true,
    opacity: 0.28,
    depthWrite: false,
    side: DoubleSide,
    toneMapped: false,
  });

  constructor() {
    // The tip at the origin, the wide end behind it: towards -z.
    this.shape.rotateX(Math.PI / 2);
    this.shape.translate(0, 0, -LENGTH_M / 2);
  }

  update(_: Cell, snapshot: Snapshot): void {
    snapshot.arms.forEach((arm, index) => {
      const funnel = (this.funnels[index] ??= this.funnel());
      funnel.visible = arm.targetValid;
      if (arm.targetValid) place(funnel, arm.target);
    });
  }

  reset(): void {
    this.root.remove(...this.funnels);
    this.funnels.length = 0;
  }

  private funnel(): Mesh {
    const mesh = new Mesh(this.shape, this.paint);
    mesh.raycast = () => {};
    this.root.add(mesh);
    return mesh;
  }
}
