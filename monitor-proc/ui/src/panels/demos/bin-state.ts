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
  const bins = scene.objects.filter(({ shape }) => shape.kind === "bin");
  return bins.slice(0, scene.bins).map(({ name }) => name);
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
    const away = isTaskOver ? "not used" : "to come";
    const here = held.has(index) ? "in flight" : placed.has(name) ? "placed" : "in the cell";
    const pose = isHere ? state.pose : null;
    const isFlipped = pose !== null && !opensUp(pose);
    all.push({ name, size: shape.size_m, place: isHere ? here : away, isFlipped, pose });
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
  const named = found.map(({ name, isFlipped }) => name + (isFlipped ? " (upside down)" : ""));
  return named.length === 0 ? "No bin is in flight." : `In flight: ${named.join(", ")}.`;
}
