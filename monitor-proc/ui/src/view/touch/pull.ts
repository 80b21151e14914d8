// Where a pulled body goes. The grabbed point stays under the pointer: in the horizontal plane
// where the camera looks down, else in the upright plane that faces the camera. A vertical pull
// leaves x and y alone.
import { Plane, type Ray, Vector3 } from "three";
import { type Lens, pixelAt } from "../lens";

/** From this pitch on the camera looks down: 20 degrees, a metre in depth is a third of one on the screen. */
const LOOKS_DOWN = Math.sin((20 * Math.PI) / 180);
/** A vertical pull from straight above needs no more than twice the pixels. */
const STEEPEST = 0.5;
const FARTHEST_M = 5;

export class Pull {
  /** Where the body's origin is pulled to (m, world frame). */
  readonly to: Vector3;
  /** From the grabbed point to the body's origin. */
  private readonly offset: Vector3;
  /** From where the pointer's ray meets the plane to the grabbed point. */
  private readonly slip = new Vector3();
  private readonly plane = new Plane();

  constructor(
    origin: Vector3,
    grabbed: Vector3,
    private readonly lens: Lens,
  ) {
    this.to = origin.clone();
    this.offset = origin.clone().sub(grabbed);
  }

  /** The pointer went to `ray`. */
  along(ray: Ray): void {
    const hit = this.meet(ray);
    if (hit === null) return;
    this.to.copy(hit).add(this.slip).add(this.offset);
    this.to.clampScalar(-FARTHEST_M, FARTHEST_M);
  }

  /** The pointer went to `ray`, `pixels` up in a picture of `height` pixels: straight up. */
  up(ray: Ray, pixels: number, height: number): void {
    const direction = this.lens.getWorldDirection(new Vector3());
    const pixel = pixelAt(this.lens, this.to, height);
    this.lift((pixels * pixel) / Math.max(STEEPEST, Math.hypot(direction.x, direction.y)), ray);
  }

  /** Raises the goal; the pointer stays at `ray`. */
  lift(metres: number, ray: Ray): void {
    this.to.z = Math.min(Math.max(this.to.z + metres, -FARTHEST_M), FARTHEST_M);
    this.slip.set(0, 0, 0);
    const hit = this.meet(ray);
    if (hit !== null) this.slip.copy(this.grabbed()).sub(hit);
  }

  private grabbed(): Vector3 {
    return this.to.clone().sub(this.offset);
  }

  private meet(ray: Ray): Vector3 | null {
    const facing = this.lens.getWorldDirection(new Vector3()).negate();
    const normal = facing.z > LOOKS_DOWN ? new Vector3(0, 0, 1) : facing.setZ(0).normalize();
    this.plane.setFromNormalAndCoplanarPoint(normal, this.grabbed().sub(this.slip));
    return ray.intersectPlane(this.plane, new Vector3());
  }
}
