// Roll, pitch and yaw (turns about the fixed x, y and z axes, in that order).

export type Quaternion = [number, number, number, number];

/** From angles in radians to w, x, y, z. */
export function fromRpy(roll: number, pitch: number, yaw: number): Quaternion {
  const [cr, sr] = [Math.cos(roll / 2), Math.sin(roll / 2)];
  const [cp, sp] = [Math.cos(pitch / 2), Math.sin(pitch / 2)];
  const [cy, sy] = [Math.cos(yaw / 2), Math.sin(yaw / 2)];
  return [
    cr * cp * cy + sr * sp * sy,
    sr * cp * cy - cr * sp * sy,
    cr * sp * cy + sr * cp * sy,
    cr * cp * sy - sr * sp * cy,
  ];
}

/** Nearer to a pitch of 90 degrees (by the sine) only the difference of roll and yaw can be measured. */
const SINGULAR = 1e-6;

/** From w, x, y, z to angles in radians. The roll is 0 where the pitch is 90 or -90 degrees. */
export function toRpy([w, x, y, z]: Quaternion): [number, number, number] {
  const sine = Math.min(Math.max(2 * (w * y - z * x), -1), 1);
  if (Math.abs(sine) > 1 - SINGULAR) return [0, Math.asin(sine), wrapped(2 * Math.atan2(z, w))];
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(sine),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}

/** The same angle between -pi and pi. */
function wrapped(angle: number): number {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}
