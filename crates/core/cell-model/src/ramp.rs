//! The brake ramp: from any commanded motion to standstill within acceleration and jerk limits,
//! one tick at a time.
//!
//! Limits apply to difference quotients over a tick, as violations are counted: acceleration is
//! the change of the commanded velocity over a tick, jerk the change of that.
//!
//! Physics brakes with it, and publishes the ramp as the setpoint from which a controller that
//! restarts continues (ADR 0007). A ramp that breaks a limit would make the stop itself a
//! violation, and the first command after it another one.

use rmp::JointLimits;
use serde::{Deserialize, Serialize};

/// A joint slower than this without acceleration is at rest (rad/s or m/s): far below the
/// tolerance of any limit, and above the rounding errors that would keep it moving.
const STANDSTILL: f64 = 1.0e-12;

/// Commanded motion of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RampState {
    /// Position (rad or m).
    pub position: f64,
    /// Velocity (rad/s or m/s).
    pub velocity: f64,
    /// Change of velocity in the last tick (rad/s² or m/s²).
    pub acceleration: f64,
}

impl RampState {
    /// The motion one tick later, braking as hard as the limits allow.
    ///
    /// The deceleration `s` is the one that uses up exactly the remaining velocity if it is
    /// reduced by the jerk limit in every tick: the sum of `s`, `s - J`, `s - 2 J`, ... over
    /// the ticks, with `J` the jerk limit times the tick. A start outside of the limits returns
    /// to them at the jerk limit. The velocity limit holds before the jerk limit: the rest of an
    /// acceleration must not carry the joint over it.
    pub fn brake(
        self,
        (velocity_limit, acceleration_limit, jerk_limit): (f64, f64, f64),
        dt: f64,
    ) -> Self {
        let change = jerk_limit * dt;
        let wanted = -self.velocity.signum()
            * deceleration(self.velocity.abs() / dt, change).min(acceleration_limit);
        // The jerk limit comes last: it holds even where the braking then takes longer.
        let acceleration = wanted.clamp(self.acceleration - change, self.acceleration + change);
        let room = (velocity_limit - self.velocity.abs()).max(0.0) / dt;
        let forward = self.velocity.signum();
        let acceleration = forward * (forward * acceleration).min(room);
        let mut velocity = self.velocity + acceleration * dt;
        if velocity.abs() <= STANDSTILL && acceleration.abs() <= change {
            velocity = 0.0;
        }
        Self {
            // The trapezoid is exact for the constant acceleration of one tick.
            position: self.position + 0.5 * (self.velocity + velocity) * dt,
            velocity,
            acceleration: (velocity - self.velocity) / dt,
        }
    }

    /// The motion one tick later at constant velocity; the remaining acceleration is reduced by
    /// the jerk limit.
    pub fn coast(self, jerk_limit: f64, dt: f64) -> Self {
        let change = jerk_limit * dt;
        let acceleration = self.acceleration - self.acceleration.clamp(-change, change);
        let velocity = self.velocity + acceleration * dt;
        Self {
            position: self.position + 0.5 * (self.velocity + velocity) * dt,
            velocity,
            acceleration,
        }
    }

    /// Whether the joint is at rest.
    pub fn is_at_rest(&self) -> bool {
        self.velocity == 0.0 && self.acceleration == 0.0
    }
}

/// Brakes every joint by one tick; returns whether all are at rest. Slices and limits have one
/// entry for each joint.
pub fn brake_all(joints: &mut [RampState], limits: &JointLimits, dt: f64) -> bool {
    let changes = limits.acceleration.iter().zip(&limits.jerk);
    let limits = limits.velocity.iter().zip(changes);
    for (joint, (velocity, (acceleration, jerk))) in joints.iter_mut().zip(limits) {
        *joint = joint.brake((*velocity, *acceleration, *jerk), dt);
    }
    joints.iter().all(RampState::is_at_rest)
}

/// First deceleration `s` of a falling series `s`, `s - change`, ... (while positive) with the
/// sum `sum`.
fn deceleration(sum: f64, change: f64) -> f64 {
    let terms = sum / change;
    // The largest k with k (k + 1) / 2 <= terms.
    let k = (0.5 * ((1.0 + 8.0 * terms).sqrt() - 1.0)).floor().max(0.0);
    (sum + change * 0.5 * k * (k + 1.0)) / (k + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const DT: f64 = 1.0e-3;

    /// Brakes to standstill and checks the limits on the way.
    fn stop(start: RampState, acceleration: f64, jerk: f64) -> RampState {
        let (mut before, mut ticks) = (start, 0);
        loop {
            let after = before.brake((10.0, acceleration, jerk), DT);
            let quotient = (after.velocity - before.velocity) / DT;
            assert!(
                quotient.abs() <= acceleration * (1.0 + 1e-6),
                "{start:?}: {quotient}"
            );
            assert!(
                (quotient - before.acceleration).abs() / DT <= jerk * (1.0 + 1e-6),
                "{start:?} at {ticks}"
            );
            if after.is_at_rest() {
                return after;
            }
            before = after;
            ticks += 1;
            assert!(ticks < 5_000, "{start:?} never stands: {after:?}");
        }
    }

    #[test]
    fn every_motion_ends_within_the_limits() {
        let mut random = Random::new(3);
        for _ in 0..5_000 {
            let acceleration = 12.5 + random.around_zero(7.5);
            let jerk = 5_000.0 + random.around_zero(4_500.0);
            let start = RampState {
                position: random.around_zero(2.0),
                velocity: random.around_zero(2.6),
                acceleration: random.around_zero(acceleration),
            };
            stop(start, acceleration, jerk);
        }
    }

    #[test]
    fn braking_takes_no_longer_than_physics_asks() {
        // 2 rad/s at 10 rad/s² and 5000 rad/s³: v²/2a plus half the ramp times.
        let start = RampState {
            position: 0.0,
            velocity: 2.0,
            acceleration: 0.0,
        };
        let path = stop(start, 10.0, 5_000.0).position;
        assert!((path - 0.202).abs() < 2e-3, "{path}");
    }

    #[test]
    fn coasting_ends_acceleration_within_the_jerk_limit() {
        let mut state = RampState {
            position: 0.0,
            velocity: 1.0,
            acceleration: 12.0,
        };
        for expected in [7.0, 2.0, 0.0, 0.0] {
            state = state.coast(5_000.0, DT);
            assert!((state.acceleration - expected).abs() < 1e-12, "{state:?}");
        }
        assert!((state.velocity - 1.009).abs() < 1e-12);
    }

    #[test]
    fn a_joint_that_stands_stays() {
        let still = RampState {
            position: 0.7,
            ..RampState::default()
        };
        assert_eq!(still.brake((2.0, 10.0, 5_000.0), DT), still);
    }

    #[test]
    fn a_brake_that_begins_while_a_joint_speeds_up_keeps_its_velocity_limit() {
        for forward in [1.0, -1.0] {
            let mut joint = RampState {
                position: 0.0,
                velocity: forward * 1.995,
                acceleration: forward * 10.0,
            };
            while !joint.is_at_rest() {
                joint = joint.brake((2.0, 10.0, 500.0), DT);
                assert!(joint.velocity.abs() <= 2.0 * (1.0 + 1e-9), "{joint:?}");
            }
        }
    }

    #[test]
    fn joints_brake_independently() {
        let limits = JointLimits {
            lower: vec![-1.0; 2],
            upper: vec![1.0; 2],
            velocity: vec![2.0; 2],
            acceleration: vec![10.0, 5.0],
            jerk: vec![5_000.0, 500.0],
        };
        let mut joints = [
            RampState {
                velocity: 1.0,
                ..RampState::default()
            },
            RampState::default(),
        ];
        let mut ticks = 0;
        while !brake_all(&mut joints, &limits, DT) {
            ticks += 1;
        }
        assert!((100..110).contains(&ticks), "{ticks}");
        assert_eq!(joints[1], RampState::default());
    }
}
