// The messages of docs/page-protocol.md.
import type { EpochSpan } from "./epochs";

export type Vec3 = [number, number, number];
/** x, y, z (m), then w, x, y, z, in the world frame. */
export type Pose = [number, number, number, number, number, number, number];

export type Shape =
  | { kind: "box"; size_m: Vec3 }
  | { kind: "sphere"; radius_m: number }
  | { kind: "cylinder"; radius_m: number; length_m: number }
  | { kind: "capsule"; radius_m: number; length_m: number }
  | { kind: "bin"; size_m: Vec3; wall_m: number }
  | { kind: "compound"; parts: { shape: Shape; pose: Pose }[] };

export interface JointSpec {
  name: string;
  kind: string;
  lower: number;
  upper: number;
  velocity: number;
  acceleration: number;
  effort: number;
  home: number;
}

export interface Gripper {
  kind: "parallel" | "suction";
  max_width_m: number;
  finger_joints: string[];
  /** Of suction; where the cup points, in the frame of the tool. */
  axis?: Vec3;
  force_limit_n?: number;
  torque_limit_n_m?: number;
}

export interface ArmSpec {
  name: string;
  robot: string;
  base: { position: Vec3; orientation_wxyz: [number, number, number, number] };
  urdf: string;
  joints: JointSpec[];
  arm_joints: number;
  gripper: Gripper | null;
  tool_link: string;
  tool: Pose;
  spheres: { link: string; center: Vec3; radius: number }[];
  meshes: string[];
}

export interface Scene {
  demo: string;
  description: string;
  camera: { eye_m: Vec3; target_m: Vec3 };
  arms: ArmSpec[];
  objects: {
    name: string;
    shape: Shape;
    colour: Vec3;
    mass_kg: number;
    friction: number;
    kind: string;
    parked?: boolean;
  }[];
  fixtures: {
    name: string;
    shape: Shape;
    pose: Pose;
    colour: Vec3;
    /** False: it only keeps motion away. */
    solid: boolean;
    friction: number;
    obstacle: number | null;
  }[];
  bins: number;
  conveyor: { fixture: string; velocity_m_s: Vec3; brings: string | null } | null;
  dispenser: { position_m: Vec3; spread_m: [number, number]; per_drop: number } | null;
  sensors: { name: string; position_m: Vec3; direction: Vec3; range_m: number }[];
  task: Record<string, unknown>;
  panel: string;
  start_event: boolean;
}

export interface DemoSpec {
  name: string;
  description: string;
  policies: string[];
  default_policy: string;
}

export interface Hello {
  role: "operator" | "viewer";
  live: boolean;
  run: {
    id: string;
    cell: string;
    /** With which a person started it; empty where none did. */
    command: string;
    demo: string;
    policy: string;
    seed: number;
    speed: string;
  };
  demos: DemoSpec[];
  source: string | null;
}

export interface ProcessStatus {
  name: string;
  state: "running" | "silent";
  pid: number | null;
  generation: number | null;
  scheduling: string | null;
  rate_hz: number;
  late_p50_us: number;
  late_p99_us: number;
  late_max_us: number;
  body_p50_us: number;
  body_p99_us: number;
  missed: number;
  /** Why cycles were missed last; empty for none. */
  missed_why: string;
  rejected: number;
  fenced: number;
  note: string;
}

export interface HopLatency {
  hop: string;
  arm: number | null;
  n: number;
  p50_us: number;
  p99_us: number;
  p999_us: number;
  max_us: number;
  buckets: [number, number][];
}

export interface SuctionStatus {
  on: boolean;
  force_n: number;
  torque_n_m: number;
  peak_force_n: number;
  peak_torque_n_m: number;
  breaks: number;
  break_limit: "" | "force" | "torque";
  break_cause: "" | "weight" | "impulse";
  refusals: number;
  refusal: string;
}

export interface EquipmentStatus {
  conveyor_speed_m_s: number;
  bins_supplied: number;
  supply_refusals: number;
  supply_refusal: string;
  parts_dropped: number;
  parts_waiting: number;
  cleared: number;
  sensors: (string | null)[];
  suction: SuctionStatus[];
}

export interface Status {
  processes: ProcessStatus[];
  task: {
    policy: string;
    outcome: "idle" | "running" | "done" | "failed" | "paused";
    phase: string;
    reason: string;
    /** What an arm has been waiting for; empty if none waits. */
    wait: string;
    drops: number;
    resyncs: number;
    aborts: number;
    recoveries: number;
    /** Whether the start event was given since the task was reset. */
    started: boolean;
    placed: string[];
    decision_age_ms: number;
    limit_violations: number;
    obstacle_contacts: number;
    self_contacts: number;
    io: { conveyor_running: boolean };
  };
  /** Why simulated time is paused; empty while it is not. */
  pause_cause: "" | "start" | "operator" | "step" | "breakpoint";
  /** The breakpoint that was reached; empty for none. */
  pause_detail: string;
  /** Asked for: `1`, `max` or a factor; null before the first state. */
  speed: string | null;
  breaks: { name: string; hits: number }[];
  equipment: EquipmentStatus | null;
  latency: HopLatency[];
  recorder: {
    state: "on" | "off" | "trouble";
    bytes: number;
    limit_bytes: number;
    file: string | null;
    gaps: number;
    note: string;
  };
  rt: "fifo" | "other" | "lockstep";
}

export interface Graph {
  name: string;
  kind: string;
  nodes: {
    id: string;
    kind: string;
    name: string;
    parent: number | null;
    detail: string;
  }[];
  edges: { from: number; to: number; label: string }[];
}

export interface LogLine {
  time_s: number;
  kind: "log" | "transition" | "lifecycle";
  text: string;
  mark: string | null;
  /** Generation of physics; null where that is not known. */
  epoch: number | null;
  /** Number of the incident this line is about. */
  incident?: number;
}

/** Without a time the message describes a state that began earlier. */
interface Change {
  /** When it changed (simulated s). */
  time_s?: number;
}

export type TextMessage =
  | ({ t: "hello" } & Hello)
  | { t: "scene"; scene: Scene }
  | ({ t: "status" } & Status)
  | { t: "graphs"; graphs: Graph[] }
  | ({ t: "statuses"; graph: number; letters: string; started?: number[] } & Change)
  | ({ t: "edge"; graph: number; label: string } & ({ from: number; to: number } | { from: null; to: null }) & Change)
  | ({ t: "keys"; graph: number; values: Record<string, string> } & Change)
  | ({ t: "guards"; graph: number; values: Record<string, boolean> } & Change)
  | { t: "log"; lines: LogLine[]; all?: boolean }
  | { t: "lanes"; spans: Span[]; all: boolean }
  | { t: "marks"; lines: LogLine[] }
  | ({ t: "timeline" } & Timeline)
  | ({ t: "ack" } & Ack)
  | ({ t: "past" } & Past)
  | { t: "now" }
  | { t: "gone"; what: string };

/** Lasts until the next span of its lane. */
export interface Span {
  lane: string;
  kind: "task" | "phase" | "grip" | "process" | "recording";
  from_s: number;
  epoch: number | null;
  /** Empty for nothing. */
  label: string;
  tone: "ok" | "info" | "warn" | "bad" | "dim";
}

/** What the flight recorder holds: the history of the newest epoch, and every epoch, oldest first. */
export interface Timeline {
  from_s: number;
  to_s: number;
  epochs: EpochSpan[];
}

/** What task and equipment said at a moment of the past. */
export interface Past {
  time_s: number;
  /** Generation of physics that was asked for. */
  epoch: number | null;
  story: TextMessage[];
  task: Status["task"];
  equipment: EquipmentStatus | null;
}

export interface Ack {
  id: number;
  ok: boolean;
  tick: number | null;
  message: string;
}

export type Command =
  | { do: "pause" | "resume" | "reset" | "again" }
  | { do: "step"; count: number }
  | { do: "task_start" | "task_pause" | "task_resume" | "task_reset" }
  | { do: "drag"; object: string; to: Vec3; for_s: number }
  | {
      do: "target";
      arm: number;
      position: Vec3;
      orientation_wxyz: [number, number, number, number];
      /** Contact force at which the arm stops (N). */
      contact_limit_n?: number;
    }
  | { do: "joints"; arm: number; positions: number[]; contact_limit_n?: number }
  | { do: "break"; name: string; on: boolean }
  | { do: "speed"; speed: string }
  | { do: "gripper"; arm: number; to: "open" | "close" }
  | { do: "drop_parts"; count: number }
  | { do: "add_bin"; flipped: boolean }
  | { do: "restart"; process: string; policy?: string }
  | { do: "load"; demo: string; policy?: string; seed: number; speed: string }
  | { do: "record"; what: "start" | "stop" | "last"; seconds?: number }
  | { do: "seek"; time_s: number | null; epoch?: number; play?: boolean; speed?: number };
