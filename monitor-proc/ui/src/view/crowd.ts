// Equal bodies in one draw call: a hundred parts cost as much time of scripts as all else in the picture.
import { DynamicDrawUsage, type Group, InstancedMesh, Mesh } from "three";
import { POINTED_LAYER } from "./touch/layers";

/** Fewer equal bodies are drawn one by one. */
const LEAST = 4;

/** One of the bodies that may be equal. */
interface Member {
  group: Group;
}

export class Crowd {
  private constructor(
    readonly mesh: InstancedMesh,
    private readonly members: Group[],
  ) {}

  /** A crowd of each kind of body that is there often enough: of one mesh, in the same shape and paint. */
  static of(bodies: readonly Member[]): Crowd[] {
    const kinds = new Map<string, Group[]>();
    for (const { group } of bodies) {
      const [mesh, ...others] = group.children;
      if (!(mesh instanceof Mesh) || others.length > 0) continue;
      const key = `${mesh.geometry.uuid} ${mesh.material.uuid}`;
      kinds.set(key, [...(kinds.get(key) ?? []), group]);
    }
    return [...kinds.values()].filter((groups) => groups.length >= LEAST).map((groups) => Crowd.made(groups));
  }

  private static made(groups: Group[]): Crowd {
    const meshes = groups.map(({ children }) => children[0] as Mesh);
    const [first] = meshes as [Mesh];
    const crowd = new InstancedMesh(first.geometry, first.material, groups.length);
    crowd.instanceMatrix.setUsage(DynamicDrawUsage);
    crowd.castShadow = crowd.receiveShadow = true;
    // Its bounds would have to be computed again with every motion.
    crowd.frustumCulled = false;
    crowd.raycast = () => {};
    crowd.count = 0;
    // The pointer still meets the bodies themselves.
    for (const mesh of meshes) mesh.layers.set(POINTED_LAYER);
    return new Crowd(crowd, groups);
  }

  /** Draws the members that are visible, each at its place. */
  update(): void {
    const { mesh } = this;
    mesh.count = 0;
    for (const group of this.members) {
      if (!group.visible) continue;
      mesh.setMatrixAt(mesh.count, group.matrix);
      mesh.count += 1;
    }
    mesh.instanceMatrix.needsUpdate = true;
  }
}
