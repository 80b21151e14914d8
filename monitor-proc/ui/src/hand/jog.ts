// Moves the target of an arm in steps, or as long as a button or a key is held.
import { stepped } from "./aims";
import type { Hand } from "./hand";

export const STEPS = {
  "1 mm, 1°": [0.001, Math.PI / 180],
  "10 mm, 10°": [0.01, Math.PI / 18],
} as const;
/** Moves while it is held. */
export const HOLD = "hold";
export type Step = keyof typeof STEPS | typeof HOLD;

/** Speeds while a button is held (m/s, rad/s): an eye follows, and a contact is felt early. */
const SPEED = [0.03, 0.2] as const;
const PERIOD_MS = 50;
/** With Shift. */
const FINE = 0.1;

export class Jog {
  step: Step = "1 mm, 1°";
  private timer = 0;

  constructor(private readonly hand: Hand) {
    addEventListener("blur", () => this.release());
  }

  /** Starts to move arm `arm` along or about axis 0 to 5 (x, y, z, roll, pitch, yaw). */
  press(arm: number, axis: number, sign: number, fine: boolean): void {
    this.release();
    this.hand.begin();
    const kind = axis < 3 ? 0 : 1;
    const scale = sign * (fine ? FINE : 1);
    if (this.step !== HOLD) {
      this.move(arm, axis, scale * STEPS[this.step][kind]);
      return;
    }
    const amount = (scale * SPEED[kind] * PERIOD_MS) / 1000;
    this.move(arm, axis, amount);
    this.timer = window.setInterval(() => {
      // It would press again at once.
      if (this.hand.isStopped || this.hand.refusal() !== null) this.release();
      else this.move(arm, axis, amount);
    }, PERIOD_MS);
  }

  release(): void {
    clearInterval(this.timer);
  }

  private move(arm: number, axis: number, amount: number): void {
    const from = this.hand.pose(arm);
    if (from !== null) this.hand.move(arm, stepped(from, axis, amount, this.hand.frame));
  }
}
