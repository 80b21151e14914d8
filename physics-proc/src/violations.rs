//! `limit_violations`: what an accepted command may not do.
//!
//! Velocity as commanded and as the quotient of positions, acceleration and jerk
//! as difference quotients, over 1 ms per command (commands that were
//! overtaken by newer ones count by their sequence numbers). Measured
//! acceleration in contact does not count.

use cell_model::JointSpec;
use cell_model::ramp::RampState;

use crate::settings::TICK_S;

/// Tolerance of rounding.
const FACTOR: f64 = 1.0 + 1.0e-6;
/// A measured joint further outside its limits counts (rad or m).
const MEASURED_OUTSIDE: f64 = 1.0e-3;

/// The motion a command makes of a joint that was commanded `before`, `steps`
/// milliseconds ago, and whether it breaks a limit.
pub(crate) fn advance(
    before: &RampState,
    position: f64,
    velocity: f64,
    steps: f64,
    spec: &JointSpec,
) -> (RampState, bool) {
    let time = steps * TICK_S;
    let acceleration = (velocity - before.velocity) / time;
    let jerk = (acceleration - before.acceleration) / time;
    let speed = velocity
        .abs()
        .max((position - before.position).abs() / time);
    let broken = speed > spec.velocity * FACTOR
        || acceleration.abs() > spec.acceleration * FACTOR
        || jerk.abs() > spec.jerk * FACTOR;
    (
        RampState {
            position,
            velocity,
            acceleration,
        },
        broken,
    )
}

/// Whether a measured position is outside the joint's limits.
pub(crate) fn outside(position: f64, spec: &JointSpec) -> bool {
    position < spec.lower - MEASURED_OUTSIDE || position > spec.upper + MEASURED_OUTSIDE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> JointSpec {
        JointSpec {
            lower: -1.0,
            upper: 1.0,
            velocity: 2.0,
            acceleration: 10.0,
            jerk: 5_000.0,
            effort: 87.0,
            stiffness: 4_500.0,
            damping: 450.0,
            armature: 0.1,
            joint_damping: 1.0,
            home: 0.0,
        }
    }

    #[test]
    fn each_limit_counts_just_above_and_not_at_it() {
        let moving = RampState {
            position: 0.0,
            velocity: 1.0,
            acceleration: 10.0,
        };
        let at =
            |velocity: f64, position: f64| advance(&moving, position, velocity, 1.0, &spec()).1;
        assert!(!at(1.01, 0.001));
        assert!(at(1.010_1, 0.001), "acceleration");
        assert!(!at(1.005, 0.001));
        assert!(at(1.004_9, 0.001), "jerk");
        assert!(at(1.01, 0.002_1), "velocity of the positions");
        let fast = RampState {
            velocity: 2.0,
            ..RampState::default()
        };
        assert!(!advance(&fast, 0.002, 2.0, 1.0, &spec()).1);
        assert!(advance(&fast, 0.002, 2.000_01, 1.0, &spec()).1, "velocity");
    }

    #[test]
    fn a_command_after_two_lost_ones_is_measured_over_three_milliseconds() {
        let before = RampState {
            position: 0.0,
            velocity: 1.0,
            acceleration: 10.0,
        };
        assert!(!advance(&before, 0.003, 1.03, 3.0, &spec()).1);
    }

    #[test]
    fn measured_positions_have_a_milliradian() {
        assert!(
            !outside(1.000_9, &spec()) && outside(1.001_1, &spec()) && outside(-1.002, &spec())
        );
    }
}
