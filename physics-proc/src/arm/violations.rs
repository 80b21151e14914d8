//! `limit_violations`: limits that an accepted command breaks.
//!
//! Velocity as commanded and as the quotient of positions, acceleration and jerk
//! as difference quotients, over 1 ms per command (commands that were
//! overtaken by newer ones count by their sequence numbers). A position has to follow from the
//! velocities: a joint that stays for a tick at full commanded speed breaks its acceleration
//! limit twice. Measured acceleration in contact does not count.

use cell_model::JointSpec;
use cell_model::ramp::RampState;

use crate::engine::settings::TICK_S;

/// Tolerance of rounding.
// Commands at a limit break it by the last bits of a division; a real violation is far larger.
const FACTOR: f64 = 1.0 + 1.0e-6;
/// Speed by which positions may differ from their velocities, besides what the acceleration limit
/// allows (rad/s or m/s): a setpoint that returns to its path, and rounding.
const APART: f64 = 1.1e-5;
/// A measured joint further outside its limits counts (rad or m).
// Limits of joints in the engine are constraints that give way a little under load.
const MEASURED_OUTSIDE: f64 = 1.0e-3;

/// The motion of a joint by the command `commanded`, if it was commanded `before` `steps` commands
/// of 1 ms ago, and whether it breaks a limit.
///
/// Of overtaken commands only the mean acceleration `m` is known. With the first
/// acceleration `a`, the last `b` (as the command states it) and `c` the jerk limit
/// times 1 ms, limits that held at every one of `n` steps leave
/// `|m - a| <= c (n + 1) / 2` and `|b - m| <= c (n - 1) / 2`. The next command is
/// measured against `b`: against `m` a sound one would seem to jump.
pub(crate) fn advance(
    before: &RampState,
    commanded: &RampState,
    steps: f64,
    spec: &JointSpec,
) -> (RampState, bool) {
    let time = steps * TICK_S;
    let mean = (commanded.velocity - before.velocity) / time;
    let last = if steps > 1.0 {
        commanded.acceleration
    } else {
        mean
    };
    let moved = commanded.position - before.position;
    let speed = commanded.velocity.abs().max(moved.abs() / time);
    let apart = (moved - 0.5 * (before.velocity + commanded.velocity) * time).abs();
    // At the end of its range a joint stays, however fast it came there after late commands.
    let is_at_end = commanded.position <= spec.lower || commanded.position >= spec.upper;
    let change = spec.jerk * FACTOR * TICK_S;
    // Speed as commanded and as travelled: each hides what the other one shows.
    let within = speed <= spec.velocity * FACTOR
        && (is_at_end || apart <= (spec.acceleration * time + APART) * time)
        && mean.abs().max(last.abs()) <= spec.acceleration * FACTOR
        && (mean - before.acceleration).abs() <= 0.5 * (steps + 1.0) * change
        && (last - mean).abs() <= 0.5 * (steps - 1.0) * change;
    (
        RampState {
            acceleration: last,
            ..*commanded
        },
        !within,
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

    /// Whether a command one tick after `before` breaks a limit.
    fn breaks(before: &RampState, position: f64, velocity: f64) -> bool {
        let commanded = RampState {
            position,
            velocity,
            acceleration: 0.0,
        };
        advance(before, &commanded, 1.0, &spec()).1
    }

    #[test]
    fn each_limit_counts_just_above_and_not_at_it() {
        let moving = RampState {
            position: 0.0,
            velocity: 1.0,
            acceleration: 10.0,
        };
        let at = |velocity: f64, position: f64| breaks(&moving, position, velocity);
        assert!(!at(1.01, 0.001));
        assert!(at(1.010_1, 0.001), "acceleration");
        assert!(!at(1.005, 0.001));
        assert!(at(1.004_9, 0.001), "jerk");
        assert!(at(1.01, 0.002_1), "velocity of the positions");
        let fast = RampState {
            velocity: 2.0,
            ..RampState::default()
        };
        assert!(!breaks(&fast, 0.002, 2.0));
        assert!(breaks(&fast, 0.002, 2.000_01), "velocity");
    }

    #[test]
    fn a_position_that_does_not_follow_from_the_velocities_counts() {
        let fast = RampState {
            velocity: 1.0,
            ..RampState::default()
        };
        assert!(!breaks(&fast, 0.001, 1.0));
        assert!(!breaks(&fast, 0.001_009, 1.0));
        assert!(breaks(&fast, 0.0, 1.0), "it stays for a tick");
        assert!(breaks(&fast, -0.001, 1.0), "it moves back");
        let near_end = RampState {
            position: 0.9999,
            ..fast
        };
        assert!(!breaks(&near_end, 1.0, 1.0), "the end of its range");
    }

    #[test]
    fn a_command_after_two_lost_ones_is_measured_over_three_milliseconds() {
        let before = RampState {
            position: 0.0,
            velocity: 1.0,
            acceleration: 10.0,
        };
        let commanded = |velocity: f64, acceleration| RampState {
            position: 0.003,
            velocity,
            acceleration,
        };
        let breaks = |commanded| advance(&before, &commanded, 3.0, &spec()).1;
        assert!(!breaks(commanded(1.03, 10.0)));
        assert!(breaks(commanded(1.030_1, 10.0)), "mean acceleration");
        assert!(breaks(commanded(1.03, 10.1)), "last acceleration");
        // Falls by the jerk limit at each of the three.
        assert!(!breaks(commanded(1.0, -5.0)));
        assert!(breaks(commanded(0.999_9, -5.0)), "jerk of the mean");
        assert!(breaks(commanded(1.0, -5.1)), "jerk to the last");
    }

    #[test]
    fn what_follows_a_lost_command_is_measured_from_what_was_lost() {
        // The acceleration goes from 0 to 5 and on to 10; the first is lost.
        let still = RampState::default();
        let commanded = |position, velocity, acceleration| RampState {
            position,
            velocity,
            acceleration,
        };
        let (second, broken) = advance(&still, &commanded(0.000_01, 0.015, 10.0), 2.0, &spec());
        assert!(!broken);
        // Back by the jerk limit.
        assert!(!advance(&second, &commanded(0.000_027, 0.020, 5.0), 1.0, &spec()).1);
        assert!(advance(&second, &commanded(0.000_027, 0.019_9, 5.0), 1.0, &spec()).1);
    }

    #[test]
    fn measured_positions_have_a_milliradian() {
        assert!(
            !outside(1.000_9, &spec()) && outside(1.001_1, &spec()) && outside(-1.002, &spec())
        );
    }
}
