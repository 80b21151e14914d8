// A ring of which a part is filled.
import { DoubleSide, Group, Mesh, MeshBasicMaterial, RingGeometry } from "three";
import { plainPaint } from "./overlay";

const SEGMENTS = 64;
const INNER_M = 0.075;
const OUTER_M = 0.088;
const EMPTY = 0x141a22;

export class Ring {
  readonly root = new Group();
  private readonly part: Mesh<RingGeometry, MeshBasicMaterial>;

  constructor() {
    this.part = ring(EMPTY, 1);
    this.part.renderOrder = 9;
    const all = ring(EMPTY, 0.7);
    all.renderOrder = 8;
    this.root.add(all, this.part);
  }

  show(share: number, colour: number): void {
    // Six corners a segment, one segment behind the other.
    this.part.geometry.setDrawRange(0, 6 * Math.round(SEGMENTS * share));
    this.part.material.color.setHex(colour);
  }
}

function ring(colour: number, opacity: number): Mesh<RingGeometry, MeshBasicMaterial> {
  const paint = new MeshBasicMaterial({ color: colour, opacity, side: DoubleSide, ...plainPaint(true) });
  const mesh = new Mesh(new RingGeometry(INNER_M, OUTER_M, SEGMENTS, 1), paint);
  mesh.raycast = () => {};
  return mesh;
}
