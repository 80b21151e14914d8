// A line from a body or a tool straight down to the surface below it, with the distance.
import { Box3, Group, Vector3 } from "three";
import type { Body, Cell } from "../cell";
import type { Labels } from "../labels";
import { bodyCaster } from "../touch/layers";
import { Strokes } from "./strokes";

const DOWN = new Vector3(0, 0, -1);
/** Share of the line above its text, which would cover the foot of the line or the surface there. */
const LABEL_SHARE = 0.5;

export class DropLine {
  readonly root = new Group();
  private readonly line: Strokes;
  private readonly caster = bodyCaster();

  constructor(colour: number) {
    this.line = new Strokes(1, colour);
    this.root.add(this.line.lines);
  }

  /** From the underside of `body`. */
  below(cell: Cell, body: Body, labels: Labels): void {
    const from = body.group.position.clone();
    from.z = new Box3().setFromObject(body.group, true).min.z;
    this.draw(cell, from, body, labels);
  }

  /** From a point, such as that of a tool. */
  from(cell: Cell, point: Vector3, labels: Labels): void {
    this.draw(cell, point.clone(), null, labels);
  }

  private draw(cell: Cell, from: Vector3, except: Body | null, labels: Labels): void {
    this.line.clear();
    // From a little above: what the body rests on can reach into it by some micrometres.
    this.caster.set(from.clone().setZ(from.z + 1e-3), DOWN);
    const hits = this.caster.intersectObjects(cell.withoutArms(), true);
    const hit = hits.find(({ object }) => {
      const owner = cell.ownerOf(object);
      return (owner.body === null || owner.body !== except) && owner.body?.group.visible !== false;
    });
    const floor = hit?.point ?? from.clone().setZ(cell.floor);
    this.line.add(from, floor);
    const millimetres = Math.max(0, 1000 * (from.z - floor.z));
    const { body = null, fixture = null } = hit === undefined ? {} : cell.ownerOf(hit.object);
    const below = body?.name ?? fixture ?? "the floor";
    const text = `${millimetres.toFixed(0)} mm to ${below.replaceAll("_", " ")}`;
    labels.show(`drop line ${this.root.id}`, text, from.clone().lerp(floor, LABEL_SHARE));
  }
}
