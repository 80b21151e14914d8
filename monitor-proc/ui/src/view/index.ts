// The 3D view: the picture of the cell, the overlays, and the actions of the operator in it.
import "./up";
import "./view.css";
import { Box3, Vector3 } from "three";
import type { Hand } from "../hand/hand";
import type { Jog } from "../hand/jog";
import type { Scene, Vec3 } from "../net/protocol";
import { FLAG, isUnreachable, type Snapshot } from "../net/snapshot";
import type { Store } from "../net/store";
import { getHash } from "../panels/hash";
import type { ViewApi } from "../panels/view-api";
import { Camera, type Covered } from "./camera";
import { Cell } from "./cell";
import { useCoarse } from "./detail";
import { Frames } from "./frames";
import { Labels } from "./labels";
import { useCheap } from "./materials";
import { looksOther, unseen } from "./motion";
import { Overlays } from "./overlays/index";
import { atRest, LEVELS, type Level, Quality, SOFTWARE_LEVEL } from "./quality";
import { Rest } from "./rest";
import { Screen } from "./screen";
import { Stage } from "./stage";
import { Toggles } from "./toggles";
import { Drag } from "./touch/drag";
import { Gizmo } from "./touch/gizmo";
import { Hints } from "./touch/hints";
import { Keys } from "./touch/keys";
import { Marks } from "./touch/marks";
import { ProposalGhost } from "./touch/proposal";
import { Selection } from "./touch/selection";

/** Of what shiny surfaces mirror, by a graphics card and by a program (pixels). */
const MIRROR = 256;
const SOFTWARE_MIRROR = 32;
const LEAST_REACH_M = 0.9;
/** Of standing back until a target is in the picture: its handles grow with the distance. */
const TARGET_ROUNDS = 12;

export class View implements ViewApi {
  readonly toggles = new Toggles();
  readonly quality: Quality;
  private readonly resting: Level;
  private readonly screen: Screen;
  private readonly stage: Stage;
  private readonly eye: Camera;
  private readonly frames: Frames;
  private readonly labels: Labels;
  private readonly overlays: Overlays;
  private readonly selection: Selection;
  private readonly drag: Drag;
  private readonly gizmo: Gizmo;
  private readonly marks: Marks;
  private readonly proposal: ProposalGhost;
  private cell: Cell | null = null;
  private shown: Snapshot | null = null;
  /** Something other than the camera changed since the last picture. */
  private stale = true;
  private framed = false;
  /** How the last picture was drawn. */
  private used: Level | null = null;
  /** Whether the newest snapshot moved the picture. */
  private moves = true;
  private readonly rest = new Rest(
    () => this.mayMove(),
    () => this.sharpen(),
  );

  constructor(
    private readonly store: Store,
    private readonly element: HTMLElement,
    hand: Hand,
    jog: Jog,
  ) {
    this.frames = new Frames(
      () => this.draw(),
      (ms) => this.quality.frame(ms),
    );
    const look = () => this.ask();
    const touch = () => this.refresh();
    const cell = () => this.cell;
    this.screen = new Screen(element);
    this.stage = new Stage(this.screen.renderer, this.screen.isSoftware ? SOFTWARE_MIRROR : MIRROR);
    this.labels = new Labels(element);
    this.eye = new Camera(this.screen.canvas, look);
    this.overlays = new Overlays(this.stage.scene, this.toggles, this.labels);
    this.gizmo = new Gizmo(this.screen.canvas, this.eye, hand, look);
    this.drag = new Drag(element, this.eye, store, cell, touch, () => this.gizmo.pointed);
    this.marks = new Marks(store, hand, touch);
    this.proposal = new ProposalGhost(hand, touch);
    new Keys(this.screen.canvas, this.eye, this.gizmo, hand, jog, (text) => store.emit("notice", { text, bad: false }));
    hand.onChange(touch);
    this.selection = new Selection(element, this.eye, cell, () => this.busy);
    new Hints(element, this.eye, store, cell, this.gizmo);
    this.stage.scene.add(this.gizmo.root, this.drag.root, this.selection.root, this.marks.root, this.proposal.root);
    this.quality = this.ladder();
    this.resting = atRest(this.screen.isSoftware);
    this.listen();
  }

  /** Whether the operator drags a body or the target now. */
  get busy(): boolean {
    return this.gizmo.dragging || this.drag.active;
  }

  /** A camera preset: 1 the scene's own, 2 top, 3 front, 4 side, 5 at the tool. */
  camera(preset: number): void {
    // A dragged object would jump to the place of the pointer in the other view.
    if (this.busy) return;
    this.eye.preset(preset, this.tool());
    this.refresh();
  }

  /** The borders of the picture that a panel covers (CSS pixels): the cell is framed in the rest. */
  cover(covered: Covered): void {
    this.eye.cover(covered);
    this.refresh();
  }

  /** Frames the selection, or the tool where nothing is selected. */
  frameSelection(): void {
    const at = this.selection.position ?? this.tool();
    if (at === null || this.busy) return;
    this.eye.focus(at);
    this.refresh();
  }

  gizmoMode(mode: "translate" | "rotate"): void {
    this.gizmo.mode(mode);
    this.refresh();
  }

  /** The arm whose target the gizmo leads, by its place in the scene. */
  get followTarget(): number {
    return this.gizmo.arm;
  }

  set followTarget(arm: number) {
    this.gizmo.arm = arm;
    this.refresh();
  }

  /** Selects an object or an arm by name; an arm also gets the gizmo. */
  select(name: string | null): void {
    this.selection.set(name);
    this.refresh();
  }

  /** Calls `listener` with the name of the selection, on every change. */
  onSelect(listener: (name: string | null) => void): () => void {
    return this.selection.onSelect(listener);
  }

  /** How the picture that is shown was drawn. */
  get picture(): string {
    return this.used?.name ?? "";
  }

  /** Pictures drawn since the page was opened. */
  get pictures(): number {
    return this.frames.drawn;
  }

  /** The picture as it is now, as the data URL of a PNG. */
  pixels(): string {
    this.draw();
    return this.screen.canvas.toDataURL("image/png");
  }

  /** Where the objects are drawn, in the world (m). */
  bodyPositions(): Record<string, Vec3> {
    this.catchUp();
    return this.cell?.positions() ?? {};
  }

  /** Where an arm's links are drawn, by the arm's place or name (m). */
  linkPositions(arm: number | string): Record<string, Vec3> {
    this.catchUp();
    const specs = this.cell?.scene.arms ?? [];
    const index = typeof arm === "number" ? arm : specs.findIndex(({ name }) => name === arm);
    return this.cell?.robot(index)?.linkPositions() ?? {};
  }

  /**
   * Where something is on the page (client pixels): an object, an arm's base,
   * `tool`, `gizmo`, or a handle of it: `gizmo x`, `gizmo y`, `gizmo z`.
   */
  screenOf(name: string): [number, number] | null {
    this.catchUp();
    const at = this.placeOf(name);
    if (at === null) return null;
    this.eye.lens.updateMatrixWorld();
    at.project(this.eye.lens);
    const frame = this.element.getBoundingClientRect();
    return [frame.left + (0.5 + at.x / 2) * frame.width, frame.top + (0.5 - at.y / 2) * frame.height];
  }

  private placeOf(name: string): Vector3 | null {
    const body = this.cell?.body(name);
    if (body != null) return body.group.position.clone();
    const [word = "", axis = null] = name.split(" ");
    if (word === "gizmo") return this.gizmo.handle(axis);
    if (name === "tool") return this.tool();
    const robot = this.cell?.robots.find(({ spec }) => spec.name === name);
    return robot?.root.position.clone() ?? null;
  }

  private tool(): Vector3 | null {
    return this.cell?.robot(this.gizmo.arm)?.toolPose().position ?? null;
  }

  private ladder(): Quality {
    const wanted = getHash("quality");
    const fixed = wanted === null ? -1 : LEVELS.findIndex((_, index) => wanted === `${index}`);
    const first = fixed >= 0 ? fixed : this.screen.isSoftware ? SOFTWARE_LEVEL : 0;
    return new Quality(first, fixed >= 0, () => this.refresh());
  }

  private use(level: Level): void {
    if (level === this.used) return;
    if (this.used === this.resting) this.quality.skip();
    this.used = level;
    this.stale = true;
    useCheap(!level.fine, this.stage.scene);
    useCoarse(level.coarse, this.stage.scene);
    this.stage.use(level);
    this.screen.use(level);
  }

  /** Nothing moves: one picture as good as it gets, however long it takes. */
  private sharpen(): void {
    if (this.quality.fixed || this.used === this.resting) return;
    this.stale = true;
    this.frames.ask();
  }

  private listen(): void {
    new ResizeObserver(() => {
      this.screen.resize();
      this.eye.resize(...this.screen.size);
      this.refresh();
      // A canvas of another size is empty until it is drawn.
      this.frames.now();
    }).observe(this.element);
    this.screen.canvas.addEventListener("webglcontextlost", () => this.labels.hide(true));
    this.screen.canvas.addEventListener("webglcontextrestored", () => {
      this.labels.hide(false);
      this.used = null;
      this.refresh();
    });
    this.toggles.onChange(() => this.refresh());
    this.selection.onSelect((name) => this.takeArm(name));
    this.store.on("scene", (scene) => this.takeScene(scene));
    this.store.on("snapshot", (snapshot) => this.takeSnapshot(snapshot));
    this.store.on("connection", (connected) => {
      if (!connected) this.drag.release();
    });
    if (this.store.scene !== null) this.takeScene(this.store.scene);
  }

  /** Draws what has changed; a cell at rest costs nothing. */
  private takeSnapshot(snapshot: Snapshot): void {
    const { shown } = this;
    // The picture that is asked for will have the newest one.
    if (this.stale && this.moves) return this.rest.stir();
    const fades = this.toggles.get("trails") && shown?.time !== snapshot.time;
    this.moves = shown === null || fades || looksOther(shown, snapshot, unseen(this.eye.pixel_m));
    if (this.moves) this.refresh();
  }

  /** Snapshots can come late: a cell that runs moves until one says that it does not. */
  private mayMove(): boolean {
    const { connected, hello, snapshot } = this.store;
    const flags = snapshot?.flags ?? 0;
    const scrubbed = hello?.live === true && (flags & FLAG.notLive) !== 0;
    return this.moves && connected && !scrubbed && (flags & FLAG.paused) === 0;
  }

  private takeArm(name: string | null): void {
    const arm = this.cell?.scene.arms.findIndex((spec) => spec.name === name) ?? -1;
    if (arm >= 0) this.gizmo.arm = arm;
    this.refresh();
  }

  private takeScene(scene: Scene): void {
    // The same scene comes again after every reconnection: the picture stays.
    if (this.cell !== null && JSON.stringify(scene) === JSON.stringify(this.cell.scene)) return;
    if (this.cell !== null) {
      this.stage.scene.remove(this.cell.root);
      this.cell.dispose();
      this.eye.forget();
    }
    this.drag.release();
    this.selection.set(null);
    this.overlays.reset();
    this.proposal.reset();
    this.gizmo.arm = 0;
    this.cell = new Cell(scene, () => this.refresh());
    this.stage.scene.add(this.cell.root);
    for (const text of this.cell.troubles) this.store.emit("notice", { text, bad: true });
    this.shown = null;
    this.framed = false;
    this.frame();
    this.refresh();
  }

  /** Light and camera for the whole cell, once more when its objects have come. */
  private frame(): void {
    if (this.cell === null || this.framed) return;
    // The first states can be older than the first one of the objects: these have no orientation yet.
    const { objects } = this.cell.scene;
    const isTold = (pose: number[], index: number) =>
      objects[index]?.parked === true || pose.slice(3).some((part) => part !== 0);
    this.framed = this.shown?.objects.every(({ pose }, index) => isTold(pose, index)) ?? false;
    const points = this.cell.outlinePoints();
    const extent = new Box3().setFromPoints(points);
    const size = extent.getSize(new Vector3());
    const reach = Math.max(LEAST_REACH_M, 0.5 * Math.hypot(size.x, size.y));
    const eye = new Vector3(...this.cell.scene.camera.eye_m);
    this.stage.arrange(this.cell.floor, extent.getCenter(new Vector3()), reach, eye);
    this.eye.frame(this.cell.scene, points, this.cell.workPoints());
  }

  private refresh(): void {
    this.stale = true;
    this.ask();
  }

  private ask(): void {
    this.rest.stir();
    this.frames.ask();
  }

  /** Moves the cell to the newest snapshot, drawn or not. */
  private catchUp(): void {
    const { cell } = this;
    const { snapshot } = this.store;
    if (cell === null || snapshot === null || snapshot === this.shown) return;
    this.shown = snapshot;
    cell.apply(snapshot);
    this.frame();
  }

  /** Answers whether the picture counts for the pace of moving ones. */
  private draw(): boolean {
    const resting = this.rest.reached && !this.quality.fixed;
    this.use(resting ? this.resting : this.quality.level);
    const moved = this.stale;
    this.stale = false;
    this.catchUp();
    if (moved) this.dress();
    this.eye.lens.updateMatrixWorld();
    this.labels.place(this.eye.lens, ...this.screen.size, this.gizmo.area(...this.screen.size));
    this.screen.draw(this.stage.scene, this.eye.lens, moved);
    return !resting;
  }

  /** Brings all that hangs on the cell to where the cell is now. */
  private dress(): void {
    const { cell, shown } = this;
    if (cell === null || shown === null) return;
    this.eye.follow(this.tool(), this.busy);
    this.labels.begin();
    this.overlays.update(cell, shown);
    this.drag.update(cell, this.labels);
    this.marks.update(cell, shown, this.gizmo.arm, this.labels);
    this.proposal.update(cell, shown, this.labels);
    this.labels.end();
    // A selected arm shows its gizmo also while it cannot lead.
    const selected = cell.scene.arms[this.gizmo.arm]?.name === this.selection.name;
    this.gizmo.update(shown, selected);
    this.selection.update();
    this.seeTarget(shown);
  }

  /** Has a target that was set outside of the picture in it. */
  private seeTarget(shown: Snapshot): void {
    const arm = shown.arms[this.gizmo.arm];
    if (this.busy || arm === undefined) return;
    const lone = isUnreachable(arm) ? [new Vector3(...arm.target.slice(0, 3))] : [];
    for (let round = 0; round < TARGET_ROUNDS; round++) {
      const tips = this.gizmo.tips();
      if (!this.eye.include(tips.length > 0 ? tips : lone)) return;
    }
  }
}
