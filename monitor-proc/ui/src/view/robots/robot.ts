// One arm of the cell: kinematics from its URDF, dressed link by link.
import { Group, type Material, Mesh, type Object3D, Quaternion, Vector3 } from "three";
import URDFLoader, { type URDFLink, type URDFRobot } from "urdf-loader";
import type { ArmSpec, Vec3 } from "../../net/protocol";
import { eitherOr } from "../detail";
import { still } from "../still";
import { fetchedMesh } from "./fetched";
import { hasShapes, ownParts } from "./own";
import { pandaDress } from "./panda";
import { type Dress, meshes } from "./part";
import { ur10Dress } from "./ur10";

const DRESSES: Record<string, Dress | undefined> = { panda: pandaDress, ur10: ur10Dress };

export class Robot {
  readonly root = new Group();
  private readonly urdf: URDFRobot;

  /** Throws where the URDF cannot be read. `changed` is called when meshes came. */
  constructor(
    readonly spec: ArmSpec,
    private readonly changed: () => void = () => {},
    private readonly ghost: Material | null = null,
  ) {
    const loader = new URDFLoader();
    loader.parseVisual = false;
    loader.parseCollision = false;
    this.urdf = loader.parse(spec.urdf);
    for (const joint of Object.values(this.urdf.joints)) {
      // What was measured is drawn, be it beyond a limit or not.
      joint.ignoreLimits = true;
    }
    const shaped = hasShapes(Object.values(this.urdf.links));
    for (const [name, link] of Object.entries(this.urdf.links)) this.dress(name, link, shaped);
    const [w, x, y, z] = spec.base.orientation_wxyz;
    this.root.position.set(...spec.base.position);
    this.root.quaternion.set(x, y, z, w);
    this.root.add(this.urdf);
    this.root.name = spec.name;
    this.setJoints(spec.joints.map((joint) => joint.home));
  }

  private dress(name: string, link: URDFLink, shaped: boolean): void {
    const { robot } = this.spec;
    const dress = Object.hasOwn(DRESSES, robot) ? DRESSES[robot] : undefined;
    const key = `${dress === undefined ? this.spec.urdf.length : ""}${robot}/${name}`;
    const built = meshes(key, () => (dress === undefined ? ownParts(link, shaped) : (dress[name]?.() ?? [])));
    for (const mesh of built) this.put(link, mesh);
    if (!this.spec.meshes.includes(name)) return;
    void fetchedMesh(robot, name).then((fetched) => {
      if (fetched === null) return;
      eitherOr(fetched, built);
      this.put(link, fetched);
      this.changed();
    });
  }

  private put(link: URDFLink, object: Object3D): void {
    const { ghost } = this;
    if (ghost !== null) {
      object.traverse((inner) => {
        if (!(inner instanceof Mesh)) return;
        inner.material = ghost;
        inner.castShadow = false;
        inner.receiveShadow = false;
      });
    }
    link.add(still(object));
  }

  /** Positions in the order of the scene's joints (rad, m). */
  setJoints(positions: ArrayLike<number>): void {
    this.spec.joints.forEach((joint, index) => {
      const position = positions[index];
      if (position !== undefined && Number.isFinite(position)) {
        this.urdf.joints[joint.name]?.setJointValue(position);
      }
    });
  }

  link(name: string): Object3D | null {
    return this.urdf.links[name] ?? null;
  }

  /** Where each link's frame is drawn, in the world (m). */
  linkPositions(): Record<string, Vec3> {
    this.root.updateWorldMatrix(true, true);
    const at = new Vector3();
    const all: [string, Vec3][] = Object.entries(this.urdf.links).map(([name, link]) => [
      name,
      at.setFromMatrixPosition(link.matrixWorld).toArray() as Vec3,
    ]);
    return Object.fromEntries(all);
  }

  /** Where its links are drawn, from the one that has the tool to the base, in the world (m). */
  chain(): Vector3[] {
    this.root.updateWorldMatrix(true, true);
    const links: Object3D[] = Object.values(this.urdf.links);
    const all: Vector3[] = [];
    for (let link: Object3D | null = this.link(this.spec.tool_link); link !== null; link = link.parent) {
      if (links.includes(link)) all.push(new Vector3().setFromMatrixPosition(link.matrixWorld));
    }
    return all;
  }

  /** How far its tool comes from the axis of its first joint, at most (m). */
  reach(): number {
    this.root.updateWorldMatrix(true, true);
    const links: Object3D[] = Object.values(this.urdf.links);
    const at = (object: Object3D) => new Vector3().setFromMatrixPosition(object.matrixWorld);
    const lengths = [this.toolPose().position.distanceTo(at(this.link(this.spec.tool_link) ?? this.root))];
    let link = this.link(this.spec.tool_link);
    while (link !== null) {
      let parent = link.parent;
      while (parent !== null && !links.includes(parent)) parent = parent.parent;
      if (parent !== null) lengths.push(at(link).distanceTo(at(parent)));
      link = parent;
    }
    // The last one is the height of the first joint.
    return lengths.slice(0, -1).reduce((sum, length) => sum + length, 0);
  }

  /** Where its tool centre point is drawn, and how it is turned there. */
  toolPose(): { position: Vector3; orientation: Quaternion } {
    this.root.updateWorldMatrix(true, true);
    const [x, y, z, qw, qx, qy, qz] = this.spec.tool;
    const frame = this.link(this.spec.tool_link) ?? this.root;
    const turn = frame.getWorldQuaternion(new Quaternion());
    return {
      position: frame.localToWorld(new Vector3(x, y, z)),
      orientation: turn.multiply(new Quaternion(qx, qy, qz, qw)),
    };
  }
}
