// The cell in 3D: what is drawn, what lies over it, and what a hand can do to it.
import "./up";
import "./view.css";
import type { Store } from "../net/store";
import { Camera } from "./camera";
import { Cell } from "./cell";
import { Frames } from "./frames";
import { useCheap } from "./materials";
import { Quality } from "./quality";
import { Screen } from "./screen";
import { Stage } from "./stage";

export class View {
  private readonly screen: Screen;
  private readonly stage: Stage;
  private readonly eye: Camera;
  private readonly frames: Frames;
  readonly quality: Quality;
  private cell: Cell | null = null;
  private framed = false;
  private moved = true;
  constructor(private readonly store: Store, element: HTMLElement) {
    this.screen = new Screen(element);
    this.stage = new Stage(this.screen.renderer);
    this.quality = new Quality(0, true, () => {});
    this.frames = new Frames(() => this.draw(), (ms) => this.quality.frame(ms));
    this.eye = new Camera(this.screen.canvas, () => this.frames?.ask());
    this.screen.use(this.quality.level);
    useCheap(!this.quality.level.fine, this.stage.scene);
    this.stage.useReflections(this.quality.level.fine);
    new ResizeObserver(() => { this.screen.resize(); this.eye.resize(...this.screen.size); this.frames.ask(); }).observe(element);
    store.on("scene", (scene) => {
      if (this.cell) this.stage.scene.remove(this.cell.root);
      this.cell = new Cell(scene, () => this.frames.ask());
      this.stage.scene.add(this.cell.root);
      this.framed = false;
      this.frames.ask();
    });
    store.on("snapshot", () => this.frames.ask());
  }
  private draw() {
    const { cell } = this;
    const { snapshot } = this.store;
    if (cell && snapshot) {
      cell.apply(snapshot);
      if (!this.framed) {
        this.framed = true;
        const extent = cell.extent();
        const c = extent.getCenter(this.eye.orbit.target.clone());
        this.stage.arrange(cell.floor, c, 0.9);
        this.eye.frame(cell.scene, extent);
      }
    }
    this.screen.draw(this.stage.scene, this.eye.lens, this.moved);
  }
  readonly toggles = { names: () => [] as string[], get: (_: string) => false, set: (_: string, __: boolean) => {} };
  camera(n: number) { this.eye.preset(n, null); }
  gizmoMode(_: "translate" | "rotate") {}
  select(_: string | null) {}
}
