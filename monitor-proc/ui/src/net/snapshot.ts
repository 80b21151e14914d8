// The binary frame of docs/page-protocol.md.
import type { Pose, Vec3 } from "./protocol";

const MAGIC = 0x31534352;
const HEADER_BYTES = 48;
/** The numbers of arms, objects and contacts. */
const COUNTS_AT = 32;
const PATH_POINTS = 24;
const ARM_WORDS = 115 + 3 * PATH_POINTS;
const OBJECT_WORDS = 14;
const CONTACT_WORDS = 8;
const MAX_JOINTS = 16;

export const FLAG = {
  paused: 1,
  lockstep: 2,
  ending: 4,
  taskPaused: 8,
  notLive: 16,
  recording: 32,
} as const;

export const OBJECT = { enabled: 1, touched: 2, dragged: 4, asleep: 8 } as const;

export interface ArmState {
  joints: number;
  fault: boolean;
  attached: boolean;
  goalActive: boolean;
  targetValid: boolean;
  physicsStop: number;
  controllerStop: number;
  clipped: number;
  positions: Float32Array;
  velocities: Float32Array;
  efforts: Float32Array;
  setpoints: Float32Array;
  accelerations: Float32Array;
  tcp: Pose;
  target: Pose;
  commanded: Pose;
  width: number;
  force: number;
  load: number;
  positionError: number;
  clearance: number;
  /** Index of the object, or null. */
  held: number | null;
  obstacleMask: number;
  /** Why the arm does not reach its goal; null while it moves or is there. */
  notReached: NotReached | null;
  /** The path that leads the arm, or null. */
  path: PlannedPath | null;
}

const REASONS = ["unreachable", "joint limit", "blocked", "singular", "local minimum", "in collision"] as const;
export type NotReached = (typeof REASONS)[number];

export interface PlannedPath {
  /** How much of it is behind the arm, 0 to 1. */
  done: number;
  /** The tool at evenly spaced points of it (m, world frame). */
  points: Vec3[];
}

export interface ObjectState {
  pose: Pose;
  flags: number;
  /** m/s, world frame. */
  linear: Vec3;
  /** rad/s, world frame. */
  angular: Vec3;
}

/** A body that takes part in a contact, by its place in the scene. */
export interface ContactBody {
  kind: "object" | "fixture" | "arm";
  index: number;
}

export interface Contact {
  a: ContactBody;
  b: ContactBody;
  /** m, world frame. */
  position: Vec3;
  /** Normal force on a (N, world frame); b feels its opposite. */
  force: Vec3;
}

export interface Snapshot {
  flags: number;
  time: number;
  tick: number;
  realTimeFactor: number;
  arms: ArmState[];
  objects: ObjectState[];
  /** Of a live cell, largest force first; of the past there are none. */
  contacts: Contact[];
}

/** An arm at rest this far from its target does not get there (m). */
const AWAY_M = 0.01;
/** Slower than this is at rest (rad/s or m/s; rad/s² or m/s²). */
const REST_RATE = 2e-3;
const REST_ACCELERATION = 0.02;

/** Whether the arm is at rest away from the target it follows. */
export function isUnreachable(arm: ArmState): boolean {
  const slow = (values: Float32Array, limit: number) => values.every((value) => Math.abs(value) < limit);
  const rests = slow(arm.velocities, REST_RATE) && slow(arm.accelerations, REST_ACCELERATION);
  return arm.goalActive && arm.targetValid && arm.positionError > AWAY_M && rests;
}

/** The snapshots in `bytes`, one after the other, up to the first that is not valid. */
export function decodeAll(bytes: ArrayBuffer): Snapshot[] {
  const all: Snapshot[] = [];
  for (let at = 0; at + HEADER_BYTES <= bytes.byteLength; ) {
    const view = new DataView(bytes, at);
    const end = at + HEADER_BYTES + 4 * wordsOf(view);
    const snapshot = decode(bytes.slice(at, end));
    if (snapshot === null) break;
    all.push(snapshot);
    at = end;
  }
  return all;
}

/** The snapshot in `frame`, or null if it is none. */
export function decode(frame: ArrayBuffer): Snapshot | null {
  if (frame.byteLength < HEADER_BYTES) return null;
  const view = new DataView(frame);
  if (view.getUint32(0, true) !== MAGIC) return null;
  if (frame.byteLength !== HEADER_BYTES + 4 * wordsOf(view)) return null;
  return new Frame(view);
}

/** Reads its parts when they are first asked for: where pictures are slow, most frames are replaced before one is drawn. */
class Frame implements Snapshot {
  readonly flags: number;
  readonly time: number;
  readonly tick: number;
  readonly realTimeFactor: number;
  private readArms: ArmState[] | null = null;
  private readObjects: ObjectState[] | null = null;
  private readContacts: Contact[] | null = null;

  constructor(private readonly view: DataView) {
    this.flags = view.getUint32(4, true);
    this.time = view.getFloat64(8, true);
    this.tick = view.getFloat64(16, true);
    this.realTimeFactor = view.getFloat64(24, true);
  }

  get arms(): ArmState[] {
    return (this.readArms ??= this.list(HEADER_BYTES, ARM_WORDS, 0, decodeArm));
  }

  get objects(): ObjectState[] {
    return (this.readObjects ??= this.list(this.end(0), OBJECT_WORDS, 1, decodeObject));
  }

  get contacts(): Contact[] {
    return (this.readContacts ??= this.list(this.end(1), CONTACT_WORDS, 2, decodeContact));
  }

  /** Where the arms end, or (1) the objects. */
  private end(part: 0 | 1): number {
    const arms = HEADER_BYTES + 4 * ARM_WORDS * this.count(0);
    return part === 0 ? arms : arms + 4 * OBJECT_WORDS * this.count(1);
  }

  private count(part: number): number {
    return this.view.getUint32(COUNTS_AT + 4 * part, true);
  }

  private list<T>(from: number, words: number, part: number, read: (view: DataView, at: number) => T): T[] {
    return Array.from({ length: this.count(part) }, (_, index) => read(this.view, from + 4 * words * index));
  }
}

function decodeObject(view: DataView, at: number): ObjectState {
  const flags = view.getUint32(at + 28, true);
  return { pose: pose(view, at), flags, linear: vec3(view, at + 32), angular: vec3(view, at + 44) };
}

function decodeContact(view: DataView, at: number): Contact {
  const bodies = { a: body(view.getUint32(at, true)), b: body(view.getUint32(at + 4, true)) };
  return { ...bodies, position: vec3(view, at + 8), force: vec3(view, at + 20) };
}

/** Words after the header. */
function wordsOf(view: DataView): number {
  const sizes = [ARM_WORDS, OBJECT_WORDS, CONTACT_WORDS];
  return sizes.reduce((sum, words, part) => sum + words * view.getUint32(COUNTS_AT + 4 * part, true), 0);
}

const KINDS = ["object", "fixture", "arm"] as const;

function body(code: number): ContactBody {
  return { kind: KINDS[code >>> 16] ?? "fixture", index: code & 0xffff };
}

function vec3(view: DataView, at: number): Vec3 {
  return [view.getFloat32(at, true), view.getFloat32(at + 4, true), view.getFloat32(at + 8, true)];
}

function decodeArm(view: DataView, at: number): ArmState {
  const u32 = (word: number) => view.getUint32(at + 4 * word, true);
  const f32 = (word: number) => view.getFloat32(at + 4 * word, true);
  // Little-endian, as every machine with a browser is. A frame starts at a multiple of four bytes.
  const joints = (word: number) => new Float32Array(view.buffer, view.byteOffset + at + 4 * word, MAX_JOINTS);
  const flags = u32(1);
  return {
    joints: u32(0),
    fault: (flags & 1) !== 0,
    attached: (flags & 2) !== 0,
    goalActive: (flags & 4) !== 0,
    targetValid: (flags & 8) !== 0,
    physicsStop: u32(2) & 0xffff,
    controllerStop: u32(2) >>> 16,
    clipped: u32(3),
    positions: joints(4),
    velocities: joints(20),
    efforts: joints(36),
    setpoints: joints(52),
    accelerations: joints(68),
    tcp: pose(view, at + 4 * 84),
    target: pose(view, at + 4 * 91),
    commanded: pose(view, at + 4 * 98),
    width: f32(105),
    force: f32(106),
    load: f32(107),
    positionError: f32(108),
    clearance: f32(109),
    held: u32(110) === 0 ? null : u32(110) - 1,
    obstacleMask: u32(111),
    notReached: REASONS[(u32(112) >>> 8) - 1] ?? null,
    path: f32(114) > 0 ? { done: f32(113) / f32(114), points: pathPoints(view, at + 4 * 115) } : null,
  };
}

function pathPoints(view: DataView, at: number): Vec3[] {
  return Array.from({ length: PATH_POINTS }, (_, point) => vec3(view, at + 12 * point));
}

function pose(view: DataView, at: number): Pose {
  const f32 = (index: number) => view.getFloat32(at + 4 * index, true);
  return [f32(0), f32(1), f32(2), f32(3), f32(4), f32(5), f32(6)];
}
