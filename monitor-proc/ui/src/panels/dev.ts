// A made-up task for `npm run dev`, at /?demo&fake (or /?demo=pair&fake), beside
// the made-up cell. Never part of the build.
import type { Graph, HopLatency, LogLine, Status } from "../net/protocol";
import type { Store } from "../net/store";

const RING = ["PRE_GRASP", "APPROACH", "GRASP", "LIFT", "TRANSPORT", "LOWER", "RELEASE", "RETRACT"];
const CUBES = ["red_cube", "blue_cube", "green_cube", "yellow_cube"];

function machine(): Graph {
  const names = [...RING, "HOLD"];
  const edges = RING.map((name, from) => {
    const label = name === "GRASP" ? "time" : name === "RELEASE" ? "time and gripper open" : "settled or timeout";
    return { from, to: from + 1, label };
  });
  edges.push({ from: 8, to: 0, label: "cube not at its goal" }, { from: 1, to: 0, label: "resync" });
  for (const from of [3, 4, 5]) edges.push({ from, to: 8, label: "drop" });
  const node = (name: string) => ({ id: name, kind: "state", name, parent: null, detail: name === "HOLD" ? "chooses the next cube" : "" });
  return { name: "fsm", kind: "machine", nodes: names.map(node), edges };
}

const TREE: [number, string, string, string][] = [
  [0, "Sequence", "job", "memory=true"],
  [1, "FrankaReset", "reset", "[max=0]; Retry"],
  [1, "Sequence", "stack", "memory=true [max=0]; Retry"],
  [2, "Selector", "next cube", "memory=true"],
  [3, "CheckStackComplete", "complete already", "required_count=3"],
  [3, "RecoverCube", "recover", "[key=shared.recovery_requested:left equals=true abort=lower_priority]; CheckBlackboard"],
  [3, "Sequence", "transfer", "memory=true"],
  [4, "AcquireCube", "acquire", ""],
  [4, "SetGripper", "open", "command='open' pre_open=0 settle=0 in_zone=true"],
  [4, "MoveToTarget", "approach", "target=local.approach position_tolerance=0.015 in_zone=true"],
  [4, "MoveToTarget", "descend", "target=local.grasp straight_lead=0.08 position_tolerance=0.005"],
  [4, "SetGripper", "grasp", "command='close' in_zone=true"],
  [4, "MoveToTarget", "lift", "target=local.lift straight_lead=0.08 monitor_grasp=true"],
  [4, "LeaveZone", "leave center", ""],
  [4, "MoveToTarget", "carry", "target=local.place_approach monitor_grasp=true"],
  [4, "SetGripper", "release", "command='open'"],
  [4, "MarkCubePlaced", "mark", "required_count=3"],
  [1, "MoveToTarget", "rest", "target=local.rest position_tolerance=0.05 [seconds=5]; Timeout"],
];

function tree(name: string): Graph {
  const path: number[] = [];
  const nodes = TREE.map(([depth, kind, title, detail], index) => {
    path[depth] = index;
    return { id: title, kind, name: title, parent: depth === 0 ? null : (path[depth - 1] ?? null), detail };
  });
  return { name, kind: "tree", nodes, edges: [] };
}

function hop(name: string, arm: number | null, p50: number): HopLatency {
  const buckets = Array.from({ length: 24 }, (_, i): [number, number] => {
    const upper = p50 * 0.4 * 1.25 ** i;
    return [upper, Math.round(60_000 * Math.exp(-(((i - 4) / 2.2) ** 2)) + (i > 9 ? 40 / (i - 8) : 0))];
  });
  return { hop: name, arm, n: 84_213, p50_us: p50, p99_us: p50 * 2.7, p999_us: p50 * 7, max_us: p50 * 31, buckets };
}

function status(placed: string[], phase: string): Status {
  const process = (name: string, rate: number, late: number, note = "") => ({
    name, state: "running" as const, pid: 4711, generation: name === "task" ? 3 : 1, scheduling: "fifo 60", rate_hz: rate,
    late_p50_us: late / 3, late_p99_us: late, late_max_us: 9 * late, body_p50_us: 140, body_p99_us: 310,
    missed: note === "" ? 0 : 3, missed_why: note === "" ? "" : "the last 3 at 41.2 s: physics started 3.1 ms late", rejected: 0, fenced: 0, note: "",
  });
  return {
    processes: [process("physics", 1000, 62), process("controller", 1000, 88, "3 cycles missed at 41.2 s: state came late"), process("task", 100, 140), process("monitor", 60, 900)],
    task: {
      policy: "fsm", outcome: "running", phase, reason: "", wait: "", drops: 1, resyncs: 2, aborts: 0, recoveries: 1, placed,
      decision_age_ms: 7, limit_violations: 0, obstacle_contacts: 0, self_contacts: 0,
      started: true, io: { conveyor_running: false },
    },
    equipment: null,
    latency: [hop("state to command", 0, 180), hop("command to drives", 0, 90), hop("state to decision", null, 420), hop("decision to controller", 0, 130)],
    recorder: { state: "on", bytes: 84e6, limit_bytes: 256e6, file: null, gaps: 0, note: "" },
    rt: "other",
    pause_cause: "",
    pause_detail: "",
    speed: "1",
    breaks: [],
  };
}

function pyramidKeys(step: number): Record<string, string> {
  const owner = ["'left'", "''", "'right'"][step % 3] ?? "''";
  return {
    "local.current_cube": "'cube_1'",
    "shared.center_owner": owner,
    "shared.cube_state:red_cube": "'placed:left'",
    "shared.cube_state:blue_cube": "'carried:left'",
    "shared.cube_state:green_cube": "'reserved:right'",
    "shared.placed:left": "{0}",
    "shared.placed:right": "{}",
    "shared.recovery_requested:left": String(step % 5 === 0),
  };
}

/** Tells `store` of a task that goes round and round. */
export function fakeFeed(store: Store): void {
  if (store.scene === null) {
    setTimeout(() => fakeFeed(store), 50);
    return;
  }
  const pair = store.scene.arms.length > 1;
  const name = pair ? "franka-pyramid" : "franka-stack";
  if (pair) {
    store.takeText({ t: "scene", scene: { ...store.scene, panel: "pyramid", task: { required_count: 3 } } });
  } else {
    store.takeText({ t: "scene", scene: { ...store.scene, task: { order: CUBES, stack_position_m: [0.55, 0.2] } } });
  }
  const demos = [
    { name: "franka-stack", description: "A Franka stacks four cubes by friction", policies: ["fsm", "ifelse", "bt"], default_policy: "fsm" },
    { name: "franka-pyramid", description: "Two Frankas take a pyramid apart", policies: ["json"], default_policy: "json" },
  ];
  const role = new URLSearchParams(location.search).has("viewer") ? "viewer" : "operator";
  const run = { id: "1", cell: "cell", command: "", demo: name, policy: pair ? "json" : "fsm", seed: 7, speed: "1" };
  store.takeText({ t: "hello", role, live: true, run, demos, source: null });
  const graphs = pair ? [tree("left"), tree("right")] : [machine(), tree("bt")];
  store.takeText({ t: "graphs", graphs });
  let step = 0;
  const say = (text: string, kind: LogLine["kind"], mark: string | null) => {
    const time_s = store.snapshot?.time ?? 0;
    store.takeText({ t: "log", lines: [{ time_s, kind, text, mark, epoch: null }] });
  };
  const advance = () => {
    step += 1;
    const at = step % 9;
    for (const [graph, { kind, nodes, edges }] of graphs.entries()) {
      const active = kind === "tree" ? 7 + ((step + 3 * graph) % 10) : at;
      const path = new Set<number>();
      for (let one: number | null | undefined = active; one != null; one = nodes[one]?.parent) path.add(one);
      const letter = (index: number) => (path.has(index) ? "R" : kind !== "tree" || index > active ? "I" : index === 4 ? "F" : "S");
      store.takeText({ t: "statuses", graph, letters: nodes.map((_, index) => letter(index)).join("") });
      const edge = edges.find(({ to }) => to === at);
      if (edge !== undefined) store.takeText({ t: "edge", graph, ...edge });
      if (pair) store.takeText({ t: "keys", graph, values: pyramidKeys(step) });
    }
    if (!pair) {
      const cube = CUBES[Math.floor(step / 9) % 4] ?? "";
      store.takeText({ t: "guards", graph: 0, values: { settled: step % 2 === 0, timeout: false, dropped: step % 11 === 0, "gripper open": at > 6 } });
      store.takeText({ t: "keys", graph: 0, values: { "local.cube": `'${cube}'`, "local.attempt": String(1 + (step % 3)) } });
      say(`${RING[(at + 7) % 8]} -> ${RING[at % 8]}`, "transition", null);
      if (step % 7 === 0) say(`[drop] ${cube} left the gripper, deciding again`, "log", "drop");
      if (step % 9 === 0) say(`[decide] -> stack ${cube}`, "log", null);
      if (step % 10 === 0) say("[task] <b>continues</b> from its record", "lifecycle", "restart");
    }
  };
  setInterval(advance, 900);
  setInterval(() => {
    store.takeText({ t: "status", ...status(CUBES.slice(0, Math.floor(step / 9) % 5), RING[step % 8] ?? "HOLD") });
    store.takeText({ t: "timeline", from_s: 0, to_s: store.snapshot?.time ?? 0, epochs: [] });
  }, 250);
  for (let i = 0; i < 12; i++) advance();
  store.on("snapshot", ({ arms, time }) => {
    for (const arm of arms) {
      arm.efforts.forEach((_, index) => (arm.efforts[index] = 60 * Math.sin(time + index)));
      arm.clipped = Math.sin(3 * time) > 0.9 ? 4 : 0;
      arm.positionError = 0.01 * Math.abs(Math.sin(time));
      arm.controllerStop = Math.sin(time / 4) > 0.8 ? 3 : 0;
    }
  });
}
