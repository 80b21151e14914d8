// Objects that fell out of the cell.
import type { Scene } from "./protocol";
import { OBJECT, type Snapshot } from "./snapshot";

/** Names of the objects that are not in the cell, and that no device brings; `Falls` has those that one brings again. */
export function lostOf(scene: Scene | null, snapshot: Snapshot | null): string[] {
  // The first states of a recording may be older than the first one of the objects: these have no orientation yet.
  const isLost = (index: number) => {
    const object = snapshot?.objects[index];
    return (
      object !== undefined && (object.flags & OBJECT.enabled) === 0 && object.pose.slice(3).some((part) => part !== 0)
    );
  };
  return (scene?.objects ?? []).flatMap(({ name, parked }, index) => (parked !== true && isLost(index) ? [name] : []));
}
