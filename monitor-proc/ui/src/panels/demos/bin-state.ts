// The bins of a job and how each of them is now.
import type { Pose, Scene, Vec3 } from "../../net/protocol";
import { OBJECT } from "../../net/snapshot";
import type { Store } from "../../net/store";

export type BinPlace = "to come" | "not used" | "in the cell" | "in flight" | "placed";

export interface Bin {
  name: string;
  size: Vec3;
  place: BinPlace;
  isFlipped: boolean;
  pose: Pose | null;
}

/** Whether a bin with this pose opens upward. */
export function opensUp([, , , , x, y]: Pose): boolean {
  return 1 - 2 * (x ** 2 + y ** 2) > 0;
}

/** Names of the bins that the job is about, in the order of the scene. */
export function jobBins(scene: Scene): string[] {
  return scene.objects.filter(({ shape }) => shape.kind === "bin").map(({ name }) => name).slice(0, scene.bins);
}

/** The bins that the job is about, in the order of the scene. */
export function binsOf(store: Store): Bin[] {
  const { scene, snapshot, status, isTaskOver } = store;
  const placed = new Set(status?.task.placed ?? []);
  const held = new Set(snapshot?.arms.map((arm) => arm.held));
  const all: Bin[] = [];
  scene?.objects.forEach(({ name, shape }: Scene["objects"][number], index) => {
    if (shape.kind !== "bin") return;
    const state = snapshot?.objects[index];
    const isHere = state !== undefined && (state.flags & OBJECT.enabled) !== 0;
    const place = !isHere ? (isTaskOver ? "not used" : "to come") : held.has(index) ? "in flight" : placed.has(name) ? "placed" : "in the cell";
    all.push({ name, size: shape.size_m, place, isFlipped: isHere && !opensUp(state.pose), pose: isHere ? state.pose : null });
  });
  return all.slice(0, scene?.bins);
}

/** Name, place and side of a bin. */
export function binWords({ name, place, isFlipped }: Bin): string {
  return `${name}: ${place}${isFlipped ? ", upside down" : ""}`;
}

/** What `bins` are in flight. */
export function flightWords(bins: Bin[]): string {
  const found = bins.filter(({ place }) => place === "in flight");
  return found.length === 0 ? "No bin is in flight." : `In flight: ${found.map(({ name, isFlipped }) => name + (isFlipped ? " (upside down)" : "")).join(", ")}.`;
}
