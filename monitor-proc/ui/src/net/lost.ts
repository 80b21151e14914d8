// Objects that fell out of the cell.
import type { Scene } from "./protocol";
import { OBJECT, type Snapshot } from "./snapshot";

/** Names of the objects that are not in the cell, and that no device brings; `Falls` has those that one brings again. */
export function lostOf(scene: Scene | null, snapshot: Snapshot | null): string[] {
  const isLost = (index: number) => ((snapshot?.objects[index]?.flags ?? OBJECT.enabled) & OBJECT.enabled) === 0;
  return (scene?.objects ?? []).flatMap(({ name, parked }, index) => (parked !== true && isLost(index) ? [name] : []));
}
