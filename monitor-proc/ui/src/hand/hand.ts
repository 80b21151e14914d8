// Leading an arm by hand: what the handle in the view, the keys, the jog buttons and the form share.
import type { Pose, Vec3 } from "../net/protocol";
import { FLAG } from "../net/snapshot";
import type { Store } from "../net/store";

/** Targets are sent at most so often while a handle is dragged. */
const SEND_MS = 50;
/** The monitor needs a moment to show the target that was just sent. */
const ECHO_MS = 500;
/** Contact force at which an arm stops (N), as physics has it. */
export const CONTACT_LIMIT_N = 30;

export type Frame = "world" | "tool";

/** A target that waits for Go. */
export interface Proposal {
  arm: number;
  pose: Pose;
}

interface Sent {
  pose: Pose;
  at: number;
}

export class Hand {
  /** Axes along which handle and keys move and turn. */
  frame: Frame = "world";
  /** Every change is sent at once; else it is proposed, and sent with Go. */
  follows = true;
  contactLimit_n = CONTACT_LIMIT_N;
  proposal: Proposal | null = null;
  private readonly sent = new Map<number, Sent>();
  /** By arm: the target that leads no longer, as text. */
  private readonly passed = new Map<number, string>();
  private wasLed = false;
  private timer = 0;
  private sentAt = -Infinity;
  private next: Proposal | null = null;
  /** The arm touched something: the gesture in progress moves it no further. */
  private stopped = false;
  private readonly listeners = new Set<() => void>();

  constructor(private readonly store: Store) {
    store.on("snapshot", () => this.watch());
    store.on("scene", () => this.forgetAll());
    store.on("newLines", (lines) => {
      if (lines.some(({ mark, text }) => mark === "hand_failed" && text.includes("stopped at a contact"))) this.stop();
    });
  }

  onChange(listener: () => void): void {
    this.listeners.add(listener);
  }

  changed(): void {
    for (const listener of this.listeners) listener();
  }

  /** Why no arm can be led by hand now, or null. */
  refusal(): string | null {
    const { snapshot, hello, scene, connected } = this.store;
    if (!connected) return "not connected to the monitor";
    if (hello?.role === "viewer") return "you are a viewer: present the operator's token (top right)";
    if (hello?.live === false) return "this is a recording: nothing can be moved";
    if (snapshot === null) return "no state yet";
    if ((snapshot.flags & FLAG.notLive) !== 0) return "you look at the past: press Live first";
    const led = scene?.task.kind === "reach" || (snapshot.flags & FLAG.taskPaused) !== 0;
    return led ? null : "the task leads the arm: pause the task first";
  }

  /** What the next motion of an arm starts from: what was proposed or sent last, else the target in force, else the tool. */
  pose(arm: number): Pose | null {
    const state = this.store.snapshot?.arms[arm];
    if (state === undefined) return null;
    if (this.proposal?.arm === arm) return this.proposal.pose;
    const sent = this.sent.get(arm);
    if (sent !== undefined && performance.now() - sent.at < ECHO_MS) return sent.pose;
    const target = this.target(arm);
    const leads = this.refusal() === null && target !== "" && target !== this.passed.get(arm);
    return leads ? state.target : state.tcp;
  }

  /** Starts a new gesture: a press of a button or a key, or a drag. */
  begin(): void {
    this.stopped = false;
  }

  /** Moves the target, or proposes it; refused silently after a contact until the next gesture. */
  move(arm: number, pose: Pose): void {
    if (this.stopped || this.refusal() !== null) return;
    if (!this.follows) {
      this.proposal = { arm, pose };
      this.changed();
      return;
    }
    this.sent.set(arm, { pose, at: performance.now() });
    this.next = { arm, pose };
    this.flush();
  }

  /** Sends a target at once; the answer of the cell. */
  async send(arm: number, pose: Pose): Promise<boolean> {
    this.proposal = null;
    this.sent.set(arm, { pose, at: performance.now() });
    const [x, y, z, ...orientation_wxyz] = pose;
    const target = { position: [x, y, z] as Vec3, orientation_wxyz, contact_limit_n: this.contactLimit_n };
    const ack = await this.store.command({ do: "target", arm, ...target });
    // A refused target is not shown again: the handle goes back.
    if (!ack.ok) this.sent.delete(arm);
    this.changed();
    return ack.ok;
  }

  /** Sends what was proposed. */
  go(): Promise<boolean> {
    const { proposal } = this;
    return proposal === null ? Promise.resolve(false) : this.send(proposal.arm, proposal.pose);
  }

  /** Drops what was proposed. */
  cancel(): void {
    this.proposal = null;
    this.changed();
  }

  /** The next motion of an arm starts from its tool. */
  fromTool(arm: number): void {
    if (this.proposal?.arm === arm) this.proposal = null;
    this.sent.delete(arm);
    this.passed.set(arm, this.target(arm));
    this.changed();
  }

  /** Whether the arm was stopped by a contact since the gesture began. */
  get isStopped(): boolean {
    return this.stopped;
  }

  private stop(): void {
    this.stopped = true;
    this.next = null;
    this.sent.clear();
    this.changed();
  }

  private target(arm: number): string {
    const state = this.store.snapshot?.arms[arm];
    return state?.targetValid === true ? JSON.stringify(state.target) : "";
  }

  private flush(): void {
    clearTimeout(this.timer);
    const wait = this.sentAt + SEND_MS - performance.now();
    if (wait > 0) {
      this.timer = window.setTimeout(() => this.flush(), wait);
      return;
    }
    const { next } = this;
    this.next = null;
    if (next === null) return;
    this.sentAt = performance.now();
    void this.send(next.arm, next.pose);
    // The handle goes where the target is once the cell shows it.
    window.setTimeout(() => this.changed(), ECHO_MS + 1);
  }

  /** What the task aimed at when it was paused leads no longer. */
  private watch(): void {
    const isLed = this.refusal() === null;
    if (isLed && !this.wasLed) {
      for (const arm of this.store.scene?.arms.keys() ?? []) this.passed.set(arm, this.target(arm));
    }
    if (!isLed && this.wasLed) this.forgetAll();
    this.wasLed = isLed;
  }

  private forgetAll(): void {
    this.proposal = null;
    this.next = null;
    this.sent.clear();
    this.passed.clear();
  }
}
