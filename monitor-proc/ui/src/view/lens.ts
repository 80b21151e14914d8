// The two cameras of three.js that the view switches between: perspective, and orthographic for top, front and side.
import { OrthographicCamera, PerspectiveCamera, Vector3 } from "three";

export type Lens = PerspectiveCamera | OrthographicCamera;

export const FIELD_OF_VIEW_DEG = 38;
const NEAR_M = 0.04;
const FAR_M = 80;

export function perspective(): PerspectiveCamera {
  return new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, NEAR_M, FAR_M);
}

/** Shows the same section as a perspective lens at the distance of its target. */
export function orthographic(): OrthographicCamera {
  return new OrthographicCamera(-1, 1, 1, -1, NEAR_M, FAR_M);
}

/** Half the height of the picture of a perspective lens at a distance (m). */
export function halfHeight(distance_m: number): number {
  return distance_m * Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360);
}

/** Height of a pixel at `point` (m), in a picture of `height` pixels. */
export function pixelAt(lens: Lens, point: Vector3, height: number): number {
  if (lens instanceof OrthographicCamera) return (lens.top - lens.bottom) / lens.zoom / height;
  const direction = lens.getWorldDirection(new Vector3());
  return (2 * halfHeight(point.clone().sub(lens.position).dot(direction))) / height;
}
