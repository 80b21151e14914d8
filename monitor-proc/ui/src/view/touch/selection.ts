// What the person points at: a click selects, a double click looks closer.
import { Group, Vector3 } from "three";
import type { Scene } from "../../net/protocol";
import { outline, place } from "../body";
import type { Camera } from "../camera";
import type { Body, Cell } from "../cell";
import { pick, rayAt } from "./pick";

const COLOUR = 0xffffff;
/** A pointer that moved farther turned the camera (pixels). */
const STILL_PX = 4;

type Listener = (name: string | null) => void;

export class Selection {
  readonly root = new Group();
  /** The selected object, arm or fixture. */
  name: string | null = null;
  private body: Body | null = null;
  private fixture: Scene["fixtures"][number] | null = null;
  private readonly listeners = new Set<Listener>();
  private down: [number, number] = [0, 0];

  constructor(
    private readonly element: HTMLElement,
    private readonly camera: Camera,
    private readonly cell: () => Cell | null,
    private readonly busy: () => boolean,
  ) {
    element.addEventListener("pointerdown", ({ clientX, clientY }) => {
      this.down = [clientX, clientY];
    });
    element.addEventListener("click", (event) => this.click(event));
    element.addEventListener("dblclick", (event) => {
      const hit = this.hit(event);
      if (hit !== null) this.camera.focus(hit.body?.group.position.clone() ?? hit.point);
    });
  }

  onSelect(listener: Listener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  set(name: string | null): void {
    if (name === this.name) return;
    this.name = name;
    this.body = name === null ? null : (this.cell()?.body(name) ?? null);
    const fixtures = this.body === null ? (this.cell()?.scene.fixtures ?? []) : [];
    this.fixture = fixtures.find((one) => one.name === name) ?? null;
    const shape = (this.body ?? this.fixture)?.shape;
    this.root.clear();
    if (shape !== undefined) this.root.add(outline(shape, COLOUR));
    this.update();
    for (const listener of this.listeners) listener(name);
  }

  update(): void {
    this.root.visible = this.fixture !== null || (this.body?.group.visible ?? false);
    if (this.fixture !== null) place(this.root, this.fixture.pose);
    if (this.body === null) return;
    this.root.position.copy(this.body.group.position);
    this.root.quaternion.copy(this.body.group.quaternion);
  }

  /** The position of the selection (m); null for an arm, or nothing. */
  get position(): Vector3 | null {
    if (this.body !== null) return this.body.group.position.clone();
    return this.fixture === null ? null : new Vector3(...this.fixture.pose.slice(0, 3));
  }

  private hit({ clientX, clientY }: MouseEvent) {
    const cell = this.cell();
    if (cell === null) return null;
    rayAt(clientX, clientY, this.element, this.camera.lens);
    return pick(cell);
  }

  private click(event: MouseEvent): void {
    const moved = Math.hypot(event.clientX - this.down[0], event.clientY - this.down[1]);
    if (moved > STILL_PX || event.shiftKey || this.busy()) return;
    const hit = this.hit(event);
    const arm = hit?.arm == null ? null : (this.cell()?.scene.arms[hit.arm]?.name ?? null);
    this.set(hit?.body?.name ?? arm ?? hit?.fixture ?? null);
  }
}
