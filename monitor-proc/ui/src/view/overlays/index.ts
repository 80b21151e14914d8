// All overlays, switched by name.
import type { Object3D } from "three";
import type { Snapshot } from "../../net/snapshot";
import type { Cell } from "../cell";
import type { Labels } from "../labels";
import type { Toggles } from "../toggles";
import { Approach } from "./approach";
import { Contacts } from "./contacts";
import { Distances } from "./distances";
import { Forces } from "./forces";
import { Ghost } from "./ghost";
import { Names } from "./names";
import type { Overlay } from "./overlay";
import { Places } from "./places";
import { Spheres } from "./spheres";
import { Suction } from "./suction";
import { Targets } from "./targets";
import { Trails } from "./trails";

export class Overlays {
  private readonly all: Overlay[] = [
    new Targets(),
    new Places(),
    new Approach(),
    new Spheres(),
    new Distances(),
    new Contacts(),
    new Forces(),
    new Suction(),
    new Trails(),
    new Ghost(),
    new Names(),
  ];

  constructor(
    scene: Object3D,
    private readonly toggles: Toggles,
    private readonly labels: Labels,
  ) {
    for (const { root, name } of this.all) {
      root.visible = toggles.get(name);
      scene.add(root);
    }
    toggles.onChange((name, on) => {
      for (const overlay of this.all.filter((one) => one.name === name)) {
        overlay.root.visible = on;
        if (!on) overlay.reset();
      }
    });
  }

  update(cell: Cell, snapshot: Snapshot): void {
    for (const overlay of this.all) {
      if (this.toggles.get(overlay.name)) overlay.update(cell, snapshot, this.labels);
    }
  }

  reset(): void {
    for (const overlay of this.all) overlay.reset();
  }
}
