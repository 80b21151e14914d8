// The cell in 3D: robots, objects and furniture of one scene.
import { Box3, Group, type Object3D, Vector3 } from "three";
import type { Scene, Shape, Vec3 } from "../net/protocol";
import { exampleTargets } from "../net/reach";
import { OBJECT, type Snapshot } from "../net/snapshot";
import { body, place } from "./body";
import { Crowd } from "./crowd";
import { fixtureCorners, floorHeight, furniture, tableCorners } from "./furniture";
import { Robot } from "./robots/robot";
import { still } from "./still";

export interface Body {
  name: string;
  shape: Shape;
  group: Group;
  /** Bits of `OBJECT`. */
  flags: number;
}

/** How far an arm that is asked for nothing may reach up (m). */
const HEADROOM_M = 0.75;
/** How much of a table may be cut off, so that the arms are not drawn too small. */
const TABLE_MARGIN = 0.15;
/** Around objects and goals there is room for the finger that pulls them (m). */
const AROUND_WORK_M = 0.08;

/** What a part of the picture belongs to; all null for the room. */
export interface Owner {
  body: Body | null;
  arm: number | null;
  /** Name of a fixture. */
  fixture: string | null;
}

export class Cell {
  readonly root = new Group();
  private readonly fixtures: Group;
  readonly robots: Robot[] = [];
  readonly bodies: Body[] = [];
  private readonly crowds: Crowd[];
  readonly floor: number;
  /** What went wrong while it was built, for the person. */
  readonly troubles: string[] = [];

  constructor(
    readonly scene: Scene,
    changed: () => void,
  ) {
    this.floor = floorHeight(scene);
    this.fixtures = still(furniture(scene, this.floor));
    this.root.add(this.fixtures);
    for (const { name, shape, colour } of scene.objects) {
      const group = still(body(name, shape, colour));
      group.visible = false;
      this.bodies.push({ name, shape, group, flags: 0 });
      this.root.add(group);
    }
    this.crowds = Crowd.of(this.bodies);
    for (const { mesh } of this.crowds) this.root.add(mesh);
    for (const spec of scene.arms) {
      try {
        const robot = new Robot(spec, changed);
        this.robots.push(robot);
        this.root.add(robot.root);
      } catch (error) {
        const what = error instanceof Error ? error.message : String(error);
        this.troubles.push(`the robot of ${spec.name} cannot be drawn: ${what}`);
      }
    }
  }

  apply(snapshot: Snapshot): void {
    for (const robot of this.robots) {
      const state = snapshot.arms[this.scene.arms.indexOf(robot.spec)];
      if (state !== undefined) robot.setJoints(state.positions);
    }
    this.bodies.forEach((item, index) => {
      const state = snapshot.objects[index];
      if (state === undefined) return;
      item.flags = state.flags;
      item.group.visible = (state.flags & OBJECT.enabled) !== 0;
      place(item.group, state.pose);
      item.group.updateMatrix();
    });
    for (const crowd of this.crowds) crowd.update();
  }

  /** Gives back what the graphics card keeps for this scene alone. */
  dispose(): void {
    for (const { mesh } of this.crowds) mesh.dispose();
  }

  /** The arm's robot, by its place in the scene. */
  robot(arm: number): Robot | null {
    const spec = this.scene.arms[arm];
    return this.robots.find((robot) => robot.spec === spec) ?? null;
  }

  body(name: string): Body | null {
    return this.bodies.find((item) => item.name === name) ?? null;
  }

  /** Objects and furniture. */
  withoutArms(): Object3D[] {
    return this.root.children.filter((child) => !this.robots.some(({ root }) => root === child));
  }

  /** The object, arm or fixture that `object` is a part of. */
  ownerOf(object: Object3D): Owner {
    const none: Owner = { body: null, arm: null, fixture: null };
    for (let at: Object3D | null = object; at !== null; at = at.parent) {
      const item = this.bodies.find(({ group }) => group === at);
      if (item !== undefined) return { ...none, body: item };
      const robot = this.robots.find(({ root }) => root === at);
      if (robot !== undefined) return { ...none, arm: this.scene.arms.indexOf(robot.spec) };
      const name = at.parent === this.fixtures ? at.name : "";
      if (name !== "" && this.scene.fixtures.some((one) => one.name === name)) return { ...none, fixture: name };
    }
    return none;
  }

  /** Points that a picture of the whole cell has to hold (m). */
  outlinePoints(): Vector3[] {
    const points = [...goals(this.scene), ...fixtureCorners(this.scene)];
    const work = this.work();
    for (const robot of this.robots) {
      const { root } = robot;
      points.push(...cornersOf(new Box3().setFromObject(root)));
      points.push(root.position.clone().setZ(root.position.z + HEADROOM_M));
      const reach = robot.reach();
      const sides = [1, -1].flatMap((sign) => [new Vector3(sign, 0, 0), new Vector3(0, sign, 0)]);
      const towards = work?.clone().sub(root.position).setZ(0).normalize();
      // Behind its back an arm that has work in front of it does nothing.
      const isUsed = (side: Vector3) => towards === undefined || side.dot(towards) > BACK;
      for (const side of sides.filter(isUsed)) points.push(root.position.clone().addScaledVector(side, reach));
      if (this.scene.task.kind === "reach") points.push(...led(robot, reach));
    }
    for (const { group } of this.bodies) {
      if (group.visible) points.push(...cornersOf(boundsOf(group)));
    }
    const middle = new Box3().setFromPoints(points).getCenter(new Vector3());
    for (const corner of tableCorners(this.scene)) {
      points.push(corner.lerp(new Vector3(middle.x, middle.y, corner.z), TABLE_MARGIN));
    }
    if (points.length === 0) points.push(new Vector3(-0.5, -0.5, 0), new Vector3(0.5, 0.5, 0.6));
    return points;
  }

  /** Points that a narrow picture has to hold: the work and what does it, without the rest of the table; none where a person leads the arm anywhere (m). */
  workPoints(): Vector3[] {
    if (this.work() === null || tableCorners(this.scene).length === 0 || this.scene.task.kind === "reach") return [];
    const shown = this.bodies.filter(({ group }) => group.visible);
    const bodies = shown.flatMap(({ group }) => cornersOf(boundsOf(group).expandByScalar(AROUND_WORK_M)));
    const places = goals(this.scene).flatMap((at) => cornersOf(new Box3(at, at.clone()).expandByScalar(AROUND_WORK_M)));
    const boxes = this.robots.flatMap(({ root }) => cornersOf(new Box3().setFromObject(root)));
    const arms = [...boxes, ...this.robots.map((robot) => robot.toolPose().position)];
    return [...places, ...fixtureCorners(this.scene), ...bodies, ...arms];
  }

  /** The middle of objects and goals; null where there are none. */
  private work(): Vector3 | null {
    const bodies = this.bodies.filter(({ group }) => group.visible).map(({ group }) => group.position);
    const all = [...goals(this.scene), ...bodies];
    return all.length === 0 ? null : new Box3().setFromPoints(all).getCenter(new Vector3());
  }

  /** Where the objects are drawn (m). */
  positions(): Record<string, Vec3> {
    return Object.fromEntries(
      this.bodies
        .filter(({ group }) => group.visible)
        .map(({ name, group }) => [name, group.getWorldPosition(new Vector3()).toArray() as Vec3]),
    );
  }
}

/** How far an arm goes that a person leads, and targets that it does not reach (m). */
function led({ root, spec }: Robot, reach: number): Vector3[] {
  const targets = exampleTargets(spec).map(([, at]) => new Vector3(...at));
  return [...targets, root.position.clone().setZ(root.position.z + reach)];
}

/** Directions of more than a right angle and a half from the work are behind an arm (cosine). */
const BACK = -0.7;

/** Its parts keep their places in it, so that three.js alone would take where they were drawn last. */
function boundsOf(object: Object3D): Box3 {
  object.updateMatrixWorld(true);
  return new Box3().setFromObject(object);
}

function cornersOf({ min, max }: Box3): Vector3[] {
  return [min.x, max.x].flatMap((x) => [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => new Vector3(x, y, z))));
}

/** Places on the table that the task's description names, of any kind. */
function goals(scene: Scene): Vector3[] {
  const found: Vector3[] = [];
  const walk = (value: unknown, key: string, depth: number) => {
    if (depth > 4 || value === null || typeof value !== "object") return;
    if (Array.isArray(value)) {
      const numbers: number[] = value.filter((item): item is number => typeof item === "number");
      if (/(position|goal).*_m$/.test(key) && numbers.length >= 2 && numbers.length === value.length) {
        found.push(new Vector3(numbers[0], numbers[1], numbers[2] ?? 0));
      }
      return;
    }
    for (const [name, inner] of Object.entries(value)) walk(inner, name, depth + 1);
  };
  walk(scene.task, "", 0);
  return found;
}
