// A made-up cell for `npm run dev`, at /?demo: no monitor is needed to work on
// the page. Never part of the build.
import pandaUrdf from "../../../robots/panda/panda.urdf?raw";
import xrdf from "../../../robots/panda/panda.xrdf?raw";
import type { ArmSpec, Pose, Scene, Vec3 } from "../src/net/protocol";
import type { Store } from "../src/net/store";
import { Robot } from "../src/view/robots/robot";
import type { ArmState, Snapshot } from "../src/net/snapshot";

const HOME = [0.012, -0.5686, 0, -2.8102, 0, 3.0366, 0.741];
const UR_HOME = [-0.3, -1.35, 1.75, -1.97, -1.57, 0];
const UR = [
  ["shoulder_pan_joint", "base_link", "shoulder_link", "0 0 0.1273", "0 0 0", "0 0 1"],
  ["shoulder_lift_joint", "shoulder_link", "upper_arm_link", "0 0.220941 0", "0 1.5707963 0", "0 1 0"],
  ["elbow_joint", "upper_arm_link", "forearm_link", "0 -0.1719 0.612", "0 0 0", "0 1 0"],
  ["wrist_1_joint", "forearm_link", "wrist_1_link", "0 0 0.5723", "0 1.5707963 0", "0 1 0"],
  ["wrist_2_joint", "wrist_1_link", "wrist_2_link", "0 0.1149 0", "0 0 0", "0 0 1"],
  ["wrist_3_joint", "wrist_2_link", "wrist_3_link", "0 0 0.1157", "0 0 0", "0 1 0"],
] as const;

function urUrdf(): string {
  const joints = UR.map(
    ([name, parent, child, xyz, rpy, axis]) =>
      `<joint name="${name}" type="revolute"><parent link="${parent}"/><child link="${child}"/>` +
      `<origin xyz="${xyz}" rpy="${rpy}"/><axis xyz="${axis}"/></joint>`,
  );
  const links = ["base_link", ...UR.map(([, , child]) => child), "ee_link"].map((n) => `<link name="${n}"/>`);
  return (
    `<robot name="ur10">${links.join("")}${joints.join("")}<joint name="ee" type="fixed">` +
    `<parent link="wrist_3_link"/><child link="ee_link"/>` +
    `<origin xyz="0 0.0922 0" rpy="0 0 1.5707963"/></joint></robot>`
  );
}

function spheres(): ArmSpec["spheres"] {
  const found: ArmSpec["spheres"] = [];
  let link = "";
  for (const line of xrdf.split("base_only")[0]?.split("\n") ?? []) {
    link = /^ {6}(\w+):$/.exec(line)?.[1] ?? link;
    const ball = /center: \[(.+?)\], radius: ([\d.]+)/.exec(line);
    if (ball === null) continue;
    const center = (ball[1] ?? "").split(",").map(Number) as Vec3;
    found.push({ link, center, radius: Number(ball[2]) });
  }
  return found;
}

function joint(name: string, home: number): ArmSpec["joints"][number] {
  return { name, kind: "revolute", lower: -3, upper: 3, velocity: 2, acceleration: 10, effort: 80, home };
}

function panda(name: string, position: Vec3): ArmSpec {
  return {
    name,
    robot: "panda",
    base: { position, orientation_wxyz: [1, 0, 0, 0] },
    urdf: pandaUrdf,
    joints: [
      ...HOME.map((home, index) => joint(`panda_joint${index + 1}`, home)),
      joint("panda_finger_joint1", 0.04),
      joint("panda_finger_joint2", 0.04),
    ],
    arm_joints: 7,
    gripper: { kind: "parallel", max_width_m: 0.08, finger_joints: ["panda_finger_joint1", "panda_finger_joint2"] },
    tool_link: "panda_hand",
    tool: [0, 0, 0.1034, 1, 0, 0, 0],
    spheres: spheres(),
    meshes: [],
  };
}

function ur10(name: string, position: Vec3): ArmSpec {
  return {
    name,
    robot: "ur10",
    base: { position, orientation_wxyz: [1, 0, 0, 0] },
    urdf: urUrdf(),
    joints: UR.map(([id], index) => joint(id, UR_HOME[index] ?? 0)),
    arm_joints: 6,
    gripper: { kind: "suction", max_width_m: 0, finger_joints: [] },
    tool_link: "ee_link",
    tool: [0.155, 0, 0, 0.7071, 0, 0.7071, 0],
    spheres: [],
    meshes: [],
  };
}

const COLOURS: Record<string, Vec3> = {
  red_cube: [0.8, 0.1, 0.1],
  blue_cube: [0.1, 0.1, 0.8],
  green_cube: [0.1, 0.7, 0.1],
  yellow_cube: [0.9, 0.8, 0.1],
};
const PLACES: Vec3[] = [
  [0.45, -0.3, 0.025],
  [0.55, -0.3, 0.025],
  [0.45, -0.45, 0.025],
  [0.55, -0.45, 0.025],
];

function scene(kind: string): Scene {
  const arms =
    kind === "pair"
      ? [panda("left", [0, -0.4, 0]), panda("right", [0, 0.4, 0])]
      : kind === "ur10"
        ? [panda("panda", [0, -0.4, 0]), ur10("ur10", [0, 0.5, 0])]
        : kind === "own"
          ? [{ ...panda("mine", [0, 0, 0]), robot: "mine" }]
          : [panda("panda", [0, 0, 0])];
  return {
    demo: "franka-stack",
    description: "made up",
    camera: { eye_m: [1.5, 0.5, 1.2], target_m: [0.5, 0, 0.2] },
    arms,
    objects: Object.entries(COLOURS).map(([name, colour]) => ({
      name,
      shape: { kind: "box", size_m: [0.05, 0.05, 0.05] },
      colour,
      mass_kg: 0.1,
      friction: 0.9,
      kind: name,
    })),
    bins: 0,
    conveyor: null,
    dispenser: null,
    sensors: [],
    fixtures: [
      {
        name: "table",
        shape: { kind: "box", size_m: [1.6, 1.8, 0.1] },
        pose: [0.3, 0, -0.05, 1, 0, 0, 0],
        colour: [0.55, 0.55, 0.58],
        solid: true,
        friction: 0.9,
        obstacle: null,
      },
      ...(kind === "pillar"
        ? [
            {
              name: "pillar",
              shape: { kind: "box" as const, size_m: [0.08, 0.08, 0.5] as Vec3 },
              pose: [0.55, 0.28, 0.25, 1, 0, 0, 0] as Scene["fixtures"][number]["pose"],
              colour: [0.75, 0.72, 0.62] as Vec3,
              solid: true,
              friction: 0.9,
              obstacle: 0,
            },
          ]
        : []),
    ],
    task: { stack_position_m: [0.55, 0.2] },
    panel: "stack",
    start_event: false,
  };
}

const models = new Map<ArmSpec, Robot>();

function posed(spec: ArmSpec, positions: Float32Array) {
  const model = models.get(spec) ?? new Robot(spec);
  models.set(spec, model);
  model.setJoints(positions);
  return model.toolPose();
}

function armState(spec: ArmSpec, time: number): ArmState {
  const positions = new Float32Array(16);
  const setpoints = new Float32Array(16);
  spec.joints.forEach((one, index) => {
    const swing = index < spec.arm_joints ? 0.25 * Math.sin(0.9 * time + index) * (index % 2) : 0;
    positions[index] = one.home + swing;
    setpoints[index] = one.home + swing * 1.5;
  });
  const { position, orientation } = posed(spec, positions);
  const { x: qx, y: qy, z: qz, w: qw } = orientation;
  const tcp: Pose = [position.x, position.y, position.z, qw, qx, qy, qz];
  const [x, y, z] = spec.base.position;
  return {
    joints: spec.arm_joints,
    fault: false,
    attached: false,
    goalActive: true,
    targetValid: true,
    physicsStop: 0,
    controllerStop: 0,
    clipped: 0,
    positions,
    velocities: new Float32Array(16),
    efforts: new Float32Array(16),
    setpoints,
    accelerations: new Float32Array(16),
    tcp,
    target: [x + 0.45, y - 0.3, z + 0.125, 0, 1, 0, 0],
    commanded: tcp,
    width: 0.08,
    force: 0,
    load: 0.6,
    positionError: 0,
    clearance: 1000,
    held: null,
    obstacleMask: 0x80000000,
    notReached: null,
    path: null,
  };
}

function snapshot(cell: Scene, time: number, flags: number): Snapshot {
  return {
    flags,
    time,
    tick: Math.round(1000 * time),
    realTimeFactor: 1,
    arms: cell.arms.map((spec) => armState(spec, time)),
    objects: PLACES.map((place, index) => ({
      pose: [...place, 1, 0, 0, 0.1 * index] as Snapshot["objects"][number]["pose"],
      flags: index === 0 ? 3 : 1,
      linear: [0, 0, 0] as Vec3,
      angular: [0, 0, 0] as Vec3,
    })),
    contacts: [],
  };
}

/** Feeds `store` as a monitor would; `?demo=pair|ur10|pillar|own`, `&still`, `&held`. */
export function startDemo(store: Store): void {
  const query = new URLSearchParams(location.search);
  const cell = scene(query.get("demo") ?? "");
  store.send = (command) => {
    console.log(JSON.stringify(command));
    return Promise.resolve({ id: 0, ok: true, tick: 0, message: "" });
  };
  store.connected = true;
  store.emit("connection", true);
  store.takeText({ t: "scene", scene: cell });
  const flags = query.has("held") ? 8 : 0;
  const show = () => {
    store.snapshot = snapshot(cell, query.has("still") ? 0 : performance.now() / 1000, flags);
    store.emit("snapshot", store.snapshot);
  };
  show();
  if (!query.has("still")) setInterval(show, 1000 / 60);
}
