// What every overlay has in common.
import type { Object3D } from "three";
import type { Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import type { Labels } from "../labels";

/** The paint of lines and marks, which light and fog do not change; `over`: they are drawn over all else. */
export function plainPaint(over: boolean) {
  return { toneMapped: false, fog: false, depthTest: !over, transparent: over };
}

/** Something drawn over the cell that can be switched on and off. */
export interface Overlay {
  readonly name: string;
  /** Added to the scene while the overlay is on. */
  readonly root: Object3D;
  /** Called for every new snapshot while it is on, after the cell has moved. */
  update(cell: Cell, snapshot: Snapshot, labels: Labels): void;
  /** Another scene: forget what was seen of the last one. */
  reset(): void;
}
