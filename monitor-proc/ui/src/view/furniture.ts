// The fixtures of the cell, with what makes them look like themselves.
import { Color, Group, Mesh, Quaternion, Vector3 } from "three";
import type { Scene, Vec3 } from "../net/protocol";
import { body, halfHeight, place, srgb } from "./body";
import { belt } from "./fixtures/belt";
import { barriers, dispenser } from "./fixtures/equipment";
import { housing, trestle } from "./fixtures/frame";
import { pallet } from "./fixtures/pallet";
import { solid } from "./fixtures/solid";
import { material } from "./materials";
import { box, cylinder } from "./shapes";

const TABLE_HEIGHT_M = 0.75;
const LEG_M = 0.07;
const PALER = 0.08;
const FRAME = { colour: 0x474a4e, roughness: 0.5, metalness: 0.1 };

type Fixture = Scene["fixtures"][number];

function isTable({ name, shape }: Fixture): boolean {
  return shape.kind === "box" && /table|bench|context/i.test(name);
}

function lowest({ shape, pose }: Fixture): number {
  return pose[2] - halfHeight(shape);
}

/** The floor of the room, which is drawn without an end. */
function isFloor({ name, shape }: Fixture): boolean {
  return shape.kind === "box" && name === "floor";
}

function corners({ shape, pose }: Fixture, faces: number[]): Vector3[] {
  if (shape.kind === "compound" || shape.kind === "sphere") return [];
  const [x, y, z] = "size_m" in shape ? shape.size_m : [2 * shape.radius_m, 2 * shape.radius_m, 2 * halfHeight(shape)];
  const turn = new Quaternion(pose[4], pose[5], pose[6], pose[3]);
  return [-1, 1].flatMap((side) =>
    [-1, 1].flatMap((end) =>
      faces.map((face) => {
        const corner = new Vector3((side * x) / 2, (end * y) / 2, (face * z) / 2).applyQuaternion(turn);
        return corner.add({ x: pose[0], y: pose[1], z: pose[2] });
      }),
    ),
  );
}

/** The corners of what the arms work on (m). */
export function tableCorners(scene: Scene): Vector3[] {
  return scene.fixtures.filter(isTable).flatMap((fixture) => corners(fixture, [1]));
}

/** The corners of the solid fixtures other than tables and the floor (m). */
export function fixtureCorners(scene: Scene): Vector3[] {
  const others = scene.fixtures.filter((one) => one.solid && !isTable(one) && !isFloor(one));
  return others.flatMap((fixture) => corners(fixture, [-1, 1]));
}

/** Height of the room's floor (m): the cell's own, or low enough for the legs of a table. */
export function floorHeight(scene: Scene): number {
  const own = scene.fixtures.find(isFloor);
  if (own !== undefined) return own.pose[2] + halfHeight(own.shape);
  const bottoms = scene.fixtures.filter(({ solid }) => solid).map(lowest);
  const bottom = Math.min(0, ...bottoms);
  return scene.fixtures.some(isTable) ? Math.min(bottom, -TABLE_HEIGHT_M) : bottom - 0.001;
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

/** A plate under an arm on a table or on the floor. */
export function mountingPlate(base: Vec3): Mesh {
  const plate = new Mesh(cylinder(0.155, 0.008, 0.003, 0.155, 48), material(FRAME));
  return solid(plate, [base[0], base[1], base[2] + 0.0035]);
}

/** Painted steel is seen mostly from its shaded sides. */
function paler(colour: Vec3): Color {
  return srgb(colour).lerp(new Color(1, 1, 1), PALER);
}

/** A box that its name lets look like more than a box, or null. */
function dressed(scene: Scene, { name, shape, colour }: Fixture): Group | null {
  if (shape.kind !== "box") return null;
  const paint = paler(colour);
  if (scene.conveyor?.fixture === name) {
    const [x, y] = scene.conveyor.velocity_m_s;
    return belt(shape.size_m, Math.abs(y) > Math.abs(x));
  }
  if (/^pallet(_\d+)?$/.test(name)) return pallet(shape.size_m, paint);
  if (/^(housing|pedestal)$/.test(name)) return housing(shape.size_m, paint);
  const isThin = shape.size_m[2] > 5 * Math.min(...shape.size_m);
  if (/(^|_)legs?(_|$)/.test(name) || (isThin && /_stand$/.test(name))) return trestle(shape.size_m, paint);
  return null;
}

/** Everything that never moves, on a floor at `floor` (m). */
export function furniture(scene: Scene, floor: number): Group {
  const all = new Group();
  for (const fixture of scene.fixtures) {
    if (!fixture.solid || isFloor(fixture)) continue;
    const { name, shape, colour } = fixture;
    const look = isTable(fixture) ? { roughness: 0.6 } : {};
    const own = dressed(scene, fixture);
    const shown = isTable(fixture) ? colour : (paler(colour).convertLinearToSRGB().toArray() as Vec3);
    const group = own === null ? body(name, shape, shown, look) : new Group().add(own);
    group.name = name;
    if (isTable(fixture)) group.add(legs(fixture, floor));
    place(group, fixture.pose);
    all.add(group);
  }
  for (const arm of scene.arms) all.add(mountingPlate(arm.base.position));
  all.add(dispenser(scene), barriers(scene, floor));
  return all;
}
