// A rim around every object that a robot, a tool or the operator touches.
import { Group } from "three";
import { OBJECT } from "../../net/snapshot";
import { outline } from "../body";
import type { Cell } from "../cell";
import type { Overlay } from "./overlay";

const TOUCHED = 0xffb02e;
const DRAGGED = 0x4cc9ff;

export class Contacts implements Overlay {
  readonly name = "contacts";
  readonly root = new Group();
  private readonly rims = new Map<string, Group>();

  update(cell: Cell): void {
    for (const rim of this.rims.values()) rim.visible = false;
    for (const { name, shape, group, flags } of cell.bodies) {
      if (!group.visible || (flags & (OBJECT.touched | OBJECT.dragged)) === 0) continue;
      const colour = (flags & OBJECT.dragged) === 0 ? TOUCHED : DRAGGED;
      const key = `${colour} ${name}`;
      let rim = this.rims.get(key);
      if (rim === undefined) {
        rim = outline(shape, colour);
        this.rims.set(key, rim);
        this.root.add(rim);
      }
      rim.visible = true;
      rim.position.copy(group.position);
      rim.quaternion.copy(group.quaternion);
    }
  }

  reset(): void {
    this.root.clear();
    this.rims.clear();
  }
}
