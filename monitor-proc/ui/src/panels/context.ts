// What all panels share: the store, the view, the selected arm, and commands.
import type { Hand } from "../hand/hand";
import { type Link, linkOf } from "../net/link";
import type { Command } from "../net/protocol";
import { FLAG, type Snapshot } from "../net/snapshot";
import type { Store } from "../net/store";
import { Pulse } from "./pulse";
import type { ViewApi } from "./view-api";

/** The cell that commands speak to when none is named. */
const USUAL_CELL = "cell";

export class PanelContext {
  readonly pulse = new Pulse();
  private selected = 0;
  private readonly armListeners = new Set<(arm: number) => void>();
  private chosen: string | null = null;
  private readonly selectListeners = new Set<(name: string | null) => void>();
  /** Opens a tab of the right side. */
  openTab: (key: string) => void = () => {};
  /** Shows the next mark of the timeline (1), or the one before (-1). */
  toMark: (direction: 1 | -1) => void = () => {};

  constructor(
    readonly store: Store,
    readonly view: ViewApi | null,
    /** Leads arms by hand. */
    readonly hand: Hand,
  ) {
    store.on("scene", () => {
      this.arm = 0;
    });
    // No place of the page may say that the cell answers while another one says that it does not.
    store.on("connection", () => this.pulse.now());
    view?.onSelect((name) => this.choose(name));
  }

  /** The selected object, fixture or arm. */
  get selection(): string | null {
    return this.chosen;
  }

  select(name: string | null): void {
    if (this.view === null) this.choose(name);
    else this.view.select(name);
  }

  onSelect(listener: (name: string | null) => void): void {
    this.selectListeners.add(listener);
  }

  private choose(name: string | null): void {
    this.chosen = name;
    const arm = this.store.scene?.arms.findIndex((one) => one.name === name) ?? -1;
    if (arm >= 0) this.arm = arm;
    for (const listener of this.selectListeners) listener(name);
  }

  /** The arm that target, gripper and joints speak of. */
  get arm(): number {
    return this.selected;
  }

  set arm(arm: number) {
    if (arm === this.selected) return;
    this.selected = arm;
    if (this.view !== null) this.view.followTarget = arm;
    for (const listener of this.armListeners) listener(arm);
  }

  onArm(listener: (arm: number) => void): void {
    this.armListeners.add(listener);
  }

  armName(arm: number): string {
    return this.store.scene?.arms[arm]?.name ?? `arm ${arm}`;
  }

  flag(flag: number): boolean {
    return ((this.snapshot?.flags ?? 0) & flag) !== 0;
  }

  get snapshot(): Snapshot | null {
    return this.store.snapshot;
  }

  /** Whether all that is shown was told before the connection was lost. */
  get isStale(): boolean {
    return this.store.hello !== null && !this.store.connected;
  }

  /** Whether the page and the monitor speak to each other. */
  get link(): Link {
    return linkOf(this.store);
  }

  get paused(): boolean {
    return this.flag(FLAG.paused);
  }

  /** Whether the task of this cell has ended: simulated time that continues brings nothing. */
  get isTaskOver(): boolean {
    return this.store.hello?.live !== false && this.store.isTaskOver;
  }

  /** Sends commands one after the other, until one is refused. */
  async send(...commands: Command[]): Promise<boolean> {
    for (const command of commands) {
      const ack = await this.store.command(command);
      if (!ack.ok) return false;
    }
    return true;
  }

  /** `commands` for the cell that is shown, where it is not the usual one. */
  onCell(commands: string): string {
    const cell = this.store.hello?.run.cell ?? USUAL_CELL;
    const named = !/^robocell (help|replay|plot)/.test(commands) && cell !== USUAL_CELL;
    const withCell = (one: string) => (/ --cell[ =]/.test(one) ? one : `${one} --cell ${cell}`);
    return named ? commands.split("; ").map(withCell).join("; ") : commands;
  }

  notify(text: string, bad = false): void {
    this.store.emit("notice", { text, bad });
  }

  /** Why nothing can be commanded now, or null. */
  refusal(): string | null {
    if (!this.store.connected) return "not connected to the monitor";
    if (this.store.hello?.role === "viewer") {
      return "you are a viewer: present the operator's token (top right)";
    }
    return null;
  }

  /** Why the cell cannot be moved now, or null. */
  cellRefusal(): string | null {
    const refusal = this.refusal();
    if (refusal !== null) return refusal;
    if (this.store.hello?.live === false) return "this is a recording: nothing can be moved";
    if (this.flag(FLAG.notLive)) return "you look at the past: press Live first";
    return null;
  }
}
