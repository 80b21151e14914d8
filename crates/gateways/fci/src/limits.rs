//! Limits of commands (libfranka 0.21, `rate_limiting.h` and `joint_velocity_limits.cpp`).

use cell_model::Robot;

use crate::JOINTS;

/// Length of a cycle (s).
pub(crate) const CYCLE_S: f64 = 1.0e-3;
/// Largest change of a commanded torque (N·m/s).
pub(crate) const TORQUE_RATE: f64 = 1000.0;
/// Limits of the end effector: velocity, acceleration and jerk, linear (m) and angular (rad).
pub(crate) const LINEAR: [f64; 3] = [3.0, 9.0, 4500.0];
/// As [`LINEAR`].
pub(crate) const ANGULAR: [f64; 3] = [2.5, 17.0, 8500.0];
/// Share by which a value may exceed its limit: a rate limiter of a client aims at the limit
/// less 1e-3 of the unit, and computes from rounded numbers.
pub(crate) const TOLERANCE: f64 = 1.0e-3;

/// Limits of one joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointLimit {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// rad/s, where no position limit is near.
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) torque: f64,
    /// Offset (rad/s) and deceleration (rad/s²) of the velocity limit near a position limit.
    pub(crate) near: Option<(f64, f64)>,
}

impl JointLimit {
    /// Whether a position (rad) is within its limits.
    pub(crate) fn allows(&self, position: f64) -> bool {
        (self.lower..=self.upper).contains(&position)
    }

    /// The position limit that is nearer to a position (rad) outside of them.
    pub(crate) fn nearest_end(&self, position: f64) -> f64 {
        if position < self.lower {
            self.lower
        } else {
            self.upper
        }
    }

    /// The limit of the velocity at a position and in the direction of `velocity` (rad/s).
    pub(crate) fn velocity_at(&self, position: f64, velocity: f64) -> f64 {
        let Some((offset, deceleration)) = self.near else {
            return self.velocity;
        };
        let way = if velocity < 0.0 {
            position - self.lower
        } else {
            self.upper - position
        };
        let braking = (2.0 * deceleration * way).max(0.0).sqrt() - offset;
        braking.clamp(0.0, self.velocity)
    }
}

/// Limits of the joints of `robot`; `None` where it has not seven revolute ones.
pub(crate) fn of(robot: &Robot) -> Option<[JointLimit; JOINTS]> {
    let mut all = Vec::with_capacity(JOINTS);
    for (index, spec) in robot.arm_specs().enumerate() {
        all.push(JointLimit {
            lower: spec.lower,
            upper: spec.upper,
            velocity: spec.velocity,
            acceleration: spec.acceleration,
            jerk: spec.jerk,
            torque: spec.effort,
            near: robot
                .velocity_envelope
                .get(index)
                .map(|near| (near.offset, near.deceleration)),
        });
    }
    let revolute = robot.arm_units().iter().all(|unit| *unit == "rad");
    all.try_into().ok().filter(|_| revolute)
}
