// The fixtures of the cell, with what makes them look like themselves.
import { Group, Mesh, Quaternion, Vector3 } from "three";
import type { Scene, Vec3 } from "../net/protocol";
import { body, halfHeight, place } from "./body";
import { material } from "./materials";
import { box, cylinder } from "./shapes";

const TABLE_HEIGHT_M = 0.75;
const LEG_M = 0.07;
const FRAME = { colour: 0x474a4e, roughness: 0.5, metalness: 0.1 };

type Fixture = Scene["fixtures"][number];

function isTable({ name, shape }: Fixture): boolean {
  return shape.kind === "box" && /table|bench|desk/i.test(name);
}

function lowest({ shape, pose }: Fixture): number {
  return pose[2] - halfHeight(shape);
}

/** The corners of what the arms work on (m). */
export function tableCorners(scene: Scene): Vector3[] {
  return scene.fixtures.filter(isTable).flatMap(({ shape, pose }) => {
    if (shape.kind !== "box") return [];
    const [x, y, z] = shape.size_m;
    const turn = new Quaternion(pose[4], pose[5], pose[6], pose[3]);
    return [-1, 1].flatMap((side) =>
      [-1, 1].map((end) => {
        const corner = new Vector3((side * x) / 2, (end * y) / 2, z / 2).applyQuaternion(turn);
        return corner.add({ x: pose[0], y: pose[1], z: pose[2] });
      }),
    );
  });
}

/** Height of the room's floor (m): a table stands on legs, all else on the floor. */
export function floorHeight(scene: Scene): number {
  const bottoms = scene.fixtures.filter(({ solid }) => solid).map(lowest);
  const bottom = Math.min(0, ...bottoms);
  return scene.fixtures.some(isTable) ? Math.min(bottom, -TABLE_HEIGHT_M) : bottom - 0.001;
}

function solid(mesh: Mesh, at: Vec3): Mesh {
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  mesh.position.set(...at);
  return mesh;
}

/** Legs under a table, down to `floor` (m). */
function legs(fixture: Fixture, floor: number): Group {
  const group = new Group();
  if (fixture.shape.kind !== "box") return group;
  const [x, y, z] = fixture.shape.size_m;
  const length = fixture.pose[2] - z / 2 - floor;
  if (length < 0.1) return group;
  const paint = material(FRAME);
  // No rails between them: software renderers let faces that are seen edge-on
  // shine through the table.
  const leg = box(LEG_M, LEG_M, length, 0);
  const reach: [number, number] = [x / 2 - 0.1, y / 2 - 0.1];
  for (const side of [-1, 1]) {
    for (const end of [-1, 1]) {
      const at: Vec3 = [side * reach[0], end * reach[1], -z / 2 - length / 2];
      group.add(solid(new Mesh(leg, paint), at));
    }
  }
  return group;
}

/** A plate under an arm that stands on a table or on the floor. */
export function mountingPlate(base: Vec3): Mesh {
  const plate = new Mesh(cylinder(0.155, 0.008, 0.003, 0.155, 48), material(FRAME));
  return solid(plate, [base[0], base[1], base[2] + 0.0035]);
}

/** Everything that never moves, on a floor at `floor` (m). */
export function furniture(scene: Scene, floor: number): Group {
  const all = new Group();
  for (const fixture of scene.fixtures.filter(({ solid }) => solid)) {
    const belt = scene.conveyor?.fixture === fixture.name;
    const look = belt ? { roughness: 0.95 } : isTable(fixture) ? { roughness: 0.6 } : {};
    const group = body(fixture.name, fixture.shape, fixture.colour, look);
    if (isTable(fixture)) group.add(legs(fixture, floor));
    place(group, fixture.pose);
    all.add(group);
  }
  for (const arm of scene.arms) all.add(mountingPlate(arm.base.position));
  return all;
}
