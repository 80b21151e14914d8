// State of the page, kept over reconnections, and the events of its changes.
import { Ages } from "./ages";
import { isCurrent, markedAt } from "./epochs";
import { Falls } from "./fallen";
import { addInOrder, isReset, withNewResets } from "./lines";
import { lostOf } from "./lost";
import { afterDone, lossesOf, resetsOf } from "./phases";
import type { Ack, Command, Graph, Hello, LogLine, Past, Scene, Span, Status, TextMessage, Timeline } from "./protocol";
import { Since } from "./since";
import { decode, type Snapshot } from "./snapshot";
import { ShownSpans } from "./spans";
import { inOrder, type Wrong, type WrongFrom } from "./wrong";

const KEPT_LINES = 2000;
/** Messages with the statuses of the task's pictures. */
const TRACE_MESSAGES = new Set(["graphs", "statuses", "edge", "keys", "guards"]);

const ENDED = "end";
/** Why a connection ends in normal operation. */
const NORMAL = new Set([ENDED, "restart"]);

/** What can change. */
export interface Events {
  connection: boolean;
  hello: Hello;
  scene: Scene;
  snapshot: Snapshot;
  status: Status;
  graphs: Graph[];
  /** Graph whose statuses, edge, keys or guards changed. */
  graph: number;
  log: LogLine[];
  /** New lines of the log. */
  newLines: LogLine[];
  timeline: Timeline;
  lanes: Span[];
  /** The moment of the past that is looked at from now on; null for now. */
  moment: Past | null;
  /** A notice for the person. */
  notice: { text: string; bad: boolean; incident?: number };
}

type Listener<K extends keyof Events> = (value: Events[K]) => void;

/** A pause by a person is marked; objects that are pulled are by the `Witness`. The end of one of several arms is no end
 * of the task. */
function withMark(line: LogLine, scene: Scene | null): LogLine {
  const { mark, text } = line;
  if (mark === null && text === "operator: pause") return { ...line, mark: "hand" };
  if (mark === null && isReset(line)) return { ...line, mark: "reset" };
  const arms = scene?.arms ?? [];
  const isPart = mark === "done" && arms.length > 1 && arms.some(({ name }) => text === `[done] ${name}`);
  return isPart ? { ...line, mark: "part" } : line;
}

/** One with the lane, epoch and beginning of a known one takes its place. */
function withSpans(known: Span[], spans: Span[]): Span[] {
  const key = (span: Span) => `${span.lane} ${span.epoch} ${span.from_s}`;
  const all = new Map(known.map((span) => [key(span), span]));
  for (const span of spans) all.set(key(span), span);
  return [...all.values()].sort((one, other) => one.from_s - other.from_s);
}

export class Store {
  connected = false;
  /** The monitor refuses the page: its link belongs to another run. */
  refused = false;
  /** The monitor said that the cell has ended. */
  ended = false;
  /** Clock time of the last message (ms); null while there was none. */
  heard_ms: number | null = null;
  hello: Hello | null = null;
  scene: Scene | null = null;
  snapshot: Snapshot | null = null;
  status: Status | null = null;
  /** What was told last about now, also while the past is shown. */
  newest: Status | null = null;
  graphs: Graph[] = [];
  letters: string[] = [];
  edges: ({ from: number; to: number; label: string } | undefined)[] = [];
  keys: Record<string, string>[] = [];
  guards: Record<string, boolean>[] = [];
  log: LogLine[] = [];
  /** Lines of what the page saw itself. */
  own: LogLine[] = [];
  /** Of a recording: all lines of its log that are marked on the timeline. */
  private marks: LogLine[] = [];
  /** Resets of the task that were told while a recording was played: they stay when an earlier moment is shown. */
  private played: LogLine[] = [];
  timeline: Timeline | null = null;
  /** What lasted from when to when, oldest first in each lane, as it was told. */
  lanes: Span[] = [];
  /** What was wrong from when on, as the states show it, oldest first. */
  wrong: WrongFrom[] = [];
  private readonly shown = new ShownSpans();
  /** Objects that fell out and can be brought again. */
  falls = new Falls();
  /** The moment of the past that is shown instead of now. */
  past: Past | null = null;
  /** The run of that moment has ended and another one began; `hasTask`: the state of the task is of the moment shown. */
  earlier: { seed: number; hasTask: boolean } | null = null;
  /** Ages of the values of guards and keys. */
  readonly ages = new Ages(() => this.snapshot?.time ?? null, this);
  readonly since = new Since();

  /** Sends a command; set by the connection. */
  send: (command: Command) => Promise<Ack> = () =>
    Promise.resolve({ id: 0, ok: false, tick: null, message: "not connected" });

  private readonly listeners = new Map<keyof Events, Set<(value: never) => void>>();

  /** Calls `listener` on every change of `what`. */
  on<K extends keyof Events>(what: K, listener: Listener<K>): () => void {
    const all = this.listeners.get(what) ?? new Set();
    all.add(listener as (value: never) => void);
    this.listeners.set(what, all);
    return () => all.delete(listener as (value: never) => void);
  }

  emit<K extends keyof Events>(what: K, value: Events[K]): void {
    for (const listener of this.listeners.get(what) ?? []) {
      (listener as Listener<K>)(value);
    }
  }

  /** Lines that have the marks of the timeline. */
  get marked(): readonly LogLine[] {
    // Of a recording the log has what was played.
    if (this.hello?.live !== false) return this.log;
    const all = this.marks.length > 0 ? this.marks : this.log;
    return [...withNewResets(all, this.played), ...this.own];
  }

  /** Names of the objects that fell out of the cell, at the moment that is shown. */
  get lost(): string[] {
    return lostOf(this.scene, this.snapshot);
  }

  /** Of these, those that a device can bring again. */
  get fallen(): string[] {
    const until_s = this.snapshot?.time ?? 0;
    return [...this.falls.out].flatMap(([name, time_s]) => (time_s <= until_s ? [name] : []));
  }

  /** The lanes of the history that led to now, as they are shown. */
  get spans(): Span[] {
    const { lanes, wrong, timeline } = this;
    return this.shown.of({ lanes, wrong, losses: lossesOf(this), resets: resetsOf(this), timeline }, (line) =>
      this.isCurrent(line),
    );
  }

  /** Whether the task has ended, and does not work again since, at the moment that is shown. */
  get isTaskOver(): boolean {
    const outcome = this.status?.task.outcome;
    return outcome === "failed" || (outcome === "done" && !afterDone(this).isAgain);
  }

  /** What was wrong at `time_s`. */
  wrongAt(time_s: number): Wrong {
    return this.wrong.filter(({ from_s }) => from_s <= time_s).at(-1)?.label ?? "";
  }

  /** Adds states that begin; what was known from `discarded_s` on is not of this history. */
  addWrong(found: WrongFrom[], discarded_s = Infinity): void {
    const kept = this.wrong.filter(({ from_s }) => from_s < discarded_s);
    if (found.length === 0 && kept.length === this.wrong.length) return;
    this.wrong = inOrder([...kept, ...found]);
    this.emit("lanes", this.lanes);
  }

  /** Whether `line` is part of the history that led to now. */
  isCurrent(line: { epoch: number | null; time_s: number }): boolean {
    return isCurrent(this.timeline?.epochs ?? [], line.epoch, line.time_s);
  }

  /** Time at which the failure or restart of `line` is marked. */
  markedAt(line: { epoch: number | null; time_s: number }): number {
    return markedAt(this.timeline?.epochs ?? [], line.epoch, line.time_s);
  }

  /** Sends a command and shows a notice when it was refused. */
  async command(command: Command): Promise<Ack> {
    const ack = await this.send(command);
    if (!ack.ok) this.emit("notice", { text: ack.message, bad: true });
    return ack;
  }

  takeFrame(frame: ArrayBuffer): void {
    const snapshot = decode(frame);
    if (snapshot === null) return;
    this.heard_ms = Date.now();
    this.snapshot = snapshot;
    this.emit("snapshot", snapshot);
  }

  takeText(message: TextMessage): void {
    // What the task says now is told again when the past was looked at.
    if (this.past !== null && TRACE_MESSAGES.has(message.t)) return;
    this.take(message);
  }

  private take(message: TextMessage): void {
    this.ages.take(message);
    this.since.take(message);
    switch (message.t) {
      case "hello":
        // Another run tells its own story; the same one tells it again, and meanwhile
        // nothing that was there is taken away.
        if (this.hello?.run.id !== message.run.id) {
          this.log = [];
          this.own = [];
          this.marks = [];
          this.played = [];
          this.timeline = null;
          this.lanes = [];
          this.wrong = [];
          this.falls = new Falls();
        }
        this.past = null;
        this.hello = message;
        this.emit("hello", message);
        break;
      case "scene":
        // Another demo has another task.
        if (this.scene?.demo !== message.scene.demo) this.takeGraphs([]);
        this.scene = message.scene;
        this.emit("scene", message.scene);
        break;
      case "status":
        this.takeStatus(message);
        break;
      case "graphs":
        this.takeGraphs(message.graphs);
        break;
      case "statuses":
        this.letters[message.graph] = message.letters;
        this.emit("graph", message.graph);
        break;
      case "edge":
        this.edges[message.graph] = message.from === null ? undefined : message;
        this.emit("graph", message.graph);
        break;
      case "keys":
        this.keys[message.graph] = { ...this.keys[message.graph], ...message.values };
        this.emit("graph", message.graph);
        break;
      case "guards":
        this.guards[message.graph] = { ...this.guards[message.graph], ...message.values };
        this.emit("graph", message.graph);
        break;
      case "log":
        this.takeLog(message.lines, message.all === true);
        break;
      case "past":
        this.takePast(message);
        break;
      case "now":
        this.past = null;
        this.clearTrace();
        for (const index of this.graphs.keys()) this.emit("graph", index);
        this.emit("moment", null);
        break;
      case "lanes":
        this.lanes = withSpans(message.all ? [] : this.lanes, message.spans);
        this.emit("lanes", this.lanes);
        break;
      case "marks":
        this.marks = message.lines.map((line) => withMark(line, this.scene));
        this.emit("lanes", this.lanes);
        break;
      case "timeline":
        this.timeline = this.withPast(message);
        this.emit("timeline", message);
        break;
      case "gone":
        this.ended = message.what === ENDED;
        // The bar above the view tells of the end, and of a monitor that does not come back.
        if (!NORMAL.has(message.what))
          this.emit("notice", { text: `the monitor closed the connection: ${message.what}`, bad: true });
        break;
      case "ack":
        break;
    }
  }

  /** While the past is shown, task and equipment are as they were then. */
  private takeStatus(status: Status): void {
    this.newest = status;
    this.heard_ms = Date.now();
    const { task, equipment } = this.past ?? status;
    this.status = { ...status, task, equipment };
    this.emit("status", this.status);
  }

  /** Shows another moment of the earlier run: of it the page has the state of physics alone. */
  showEarlier(snapshot: Snapshot): void {
    if (this.past === null || this.earlier === null) return;
    this.earlier.hasTask &&= snapshot.time === this.snapshot?.time;
    this.past = { ...this.past, time_s: snapshot.time, story: [] };
    this.snapshot = snapshot;
    this.emit("snapshot", snapshot);
    this.emit("moment", this.past);
  }

  /** Returns to now, which the monitor tells about. */
  leaveEarlier(): void {
    this.earlier = this.past = null;
    this.emit("moment", null);
  }

  /** What the recorder has removed since the past is looked at is still there for this page. */
  private withPast(timeline: Timeline): Timeline {
    const shown = this.past === null ? null : this.timeline;
    if (shown === null || shown.from_s >= timeline.from_s) return timeline;
    const gone = shown.epochs.filter(({ epoch }) => timeline.epochs.every((one) => one.epoch !== epoch));
    return { ...timeline, from_s: shown.from_s, epochs: [...gone, ...timeline.epochs] };
  }

  private takeLog(lines: LogLine[], all: boolean): void {
    const known = this.log.length;
    if (all) this.log = [];
    const marked = lines.map((line) => withMark(line, this.scene));
    if (this.hello?.live === false) this.played = withNewResets(this.played, marked);
    const isInOrder = marked.map((line) => addInOrder(this.log, line)).every((isLast) => isLast);
    if (all)
      this.insertOwn(
        this.hello?.live === false ? this.own.filter(({ time_s }) => time_s <= (this.snapshot?.time ?? 0)) : this.own,
      );
    this.log.splice(0, this.log.length - KEPT_LINES);
    // Nothing new was said where all is told once more.
    this.emit("log", !isInOrder || (all && (known > 0 || this.own.length > 0)) ? [] : marked);
    if (!all) this.emit("newLines", lines);
  }

  /** Adds lines of what the page saw itself; a recording shows them when they are played. */
  addOwn(lines: LogLine[]): void {
    this.own.push(...lines);
    const until_s = this.hello?.live === false ? (this.snapshot?.time ?? 0) : Infinity;
    this.showOwn((line) => lines.includes(line) && line.time_s <= until_s);
  }

  /** Shows the own lines that `fits` chooses. */
  showOwn(fits: (line: LogLine) => boolean): void {
    const lines = this.own.filter((line) => fits(line) && !this.log.includes(line));
    if (lines.length === 0) return;
    this.insertOwn(lines);
    const isNewest = lines.every((line, index) => this.log[this.log.length - lines.length + index] === line);
    this.emit("log", isNewest ? lines : []);
  }

  /** Each before what came later. */
  private insertOwn(lines: LogLine[]): void {
    for (const line of lines) {
      const at = this.log.findIndex(({ epoch, time_s }) => epoch === line.epoch && time_s > line.time_s);
      this.log.splice(at < 0 ? this.log.length : at, 0, line);
    }
  }

  private takePast(past: Past): void {
    this.past = past;
    this.clearTrace();
    for (const message of past.story) {
      // A recording may have begun too late for the pictures: those of now stay.
      if (message.t !== "graphs" || message.graphs.length > 0) this.take(message);
    }
    for (const index of this.graphs.keys()) this.emit("graph", index);
    if (this.newest !== null) this.takeStatus(this.newest);
    this.emit("moment", past);
  }

  private clearTrace(): void {
    this.letters = [];
    this.edges = [];
    this.keys = [];
    this.guards = [];
    this.ages.forget();
    this.since.forget();
  }

  private takeGraphs(graphs: Graph[]): void {
    // A restarted task draws the same picture again: what was seen stays.
    if (JSON.stringify(graphs) === JSON.stringify(this.graphs)) return;
    this.graphs = graphs;
    this.clearTrace();
    this.emit("graphs", graphs);
  }
}
