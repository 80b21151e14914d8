// The spheres of collision avoidance, and a veil over the obstacles they avoid.
import { Color, Group, InstancedMesh, Matrix4, MeshLambertMaterial, SphereGeometry } from "three";
import type { Snapshot } from "../../net/snapshot";
import { outline, place } from "../body";
import type { Cell } from "../cell";
import { balls } from "./ball";
import { activeObstacles } from "./obstacle";
import type { Overlay } from "./overlay";

const CALM = new Color(0x39a0ff);
const VEIL = 0xffa94d;

export class Spheres implements Overlay {
  readonly name = "spheres";
  readonly root = new Group();
  private readonly sets: InstancedMesh[] = [];
  private readonly veils = new Map<string, Group>();
  private readonly shape = new SphereGeometry(1, 14, 10);
  private readonly paint = new MeshLambertMaterial({
    color: CALM,
    transparent: true,
    opacity: 0.35,
    depthWrite: false,
  });

  update(cell: Cell, snapshot: Snapshot): void {
    const matrix = new Matrix4();
    cell.robots.forEach((robot, index) => {
      const set = (this.sets[index] ??= this.make(robot.spec.spheres.length));
      const all = balls(robot);
      all.forEach(({ centre, radius }, at) => {
        set.setMatrixAt(at, matrix.makeScale(radius, radius, radius).setPosition(centre));
      });
      set.count = all.length;
      set.instanceMatrix.needsUpdate = true;
    });
    this.veil(cell, snapshot);
  }

  private veil(cell: Cell, snapshot: Snapshot): void {
    const active = activeObstacles(cell.scene, snapshot);
    for (const [name, rim] of this.veils) rim.visible = active.some((one) => one.name === name);
    for (const { name, shape, pose } of active) {
      if (this.veils.has(name)) continue;
      const rim = outline(shape, VEIL);
      place(rim, pose);
      this.root.add(rim);
      this.veils.set(name, rim);
    }
  }

  reset(): void {
    this.root.clear();
    for (const set of this.sets) set.dispose();
    this.sets.length = 0;
    this.veils.clear();
  }

  private make(count: number): InstancedMesh {
    const set = new InstancedMesh(this.shape, this.paint, Math.max(1, count));
    set.frustumCulled = false;
    set.raycast = () => {};
    this.root.add(set);
    return set;
  }
}
