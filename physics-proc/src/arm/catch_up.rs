//! Returns a setpoint to the commanded path within the acceleration limit, after commands were
//! late or overtaken.

use cell_model::JointSpec;
use cell_model::ramp::RampState;

use crate::engine::settings::TICK_S;

/// Share of the distance to the path that is removed in one tick.
// The distance then shrinks by a factor in each tick; 1 would ask one tick for all of it.
const GAIN: f64 = 0.3;
/// Distance from the path below which the setpoint is on it (rad or m).
// Far below what a tracking error or a limit's tolerance can resolve.
const ON_PATH: f64 = 1.0e-8;

/// One tick from the setpoint `before` towards `commanded`, the newest point of the path. On the
/// path the result is `commanded`, to the bit.
pub(crate) fn catch_up(before: &RampState, commanded: &RampState, spec: &JointSpec) -> RampState {
    let change = spec.acceleration * TICK_S;
    let ahead = commanded.position
        - before.position
        - 0.5 * (before.velocity + commanded.velocity) * TICK_S;
    let is_near = (commanded.velocity - before.velocity).abs() <= change && ahead.abs() <= ON_PATH;
    if is_near {
        return *commanded;
    }
    // Not faster than half of the acceleration limit can take back, or it would overshoot.
    let most = (spec.acceleration * ahead.abs()).sqrt();
    let correction = (GAIN * ahead / TICK_S).clamp(-most, most);
    let wanted = (commanded.velocity + correction).clamp(-spec.velocity, spec.velocity);
    let velocity = wanted.clamp(before.velocity - change, before.velocity + change);
    let position = before.position + 0.5 * (before.velocity + velocity) * TICK_S;
    RampState {
        position: position.clamp(spec.lower, spec.upper),
        velocity,
        acceleration: continuable(velocity, (velocity - before.velocity) / TICK_S, spec),
    }
}

/// One tick without a command, the first or a later one `in_a_row`, within the joint's
/// limits: the acceleration is kept for one tick, as most gaps are that short, and
/// taken back by the jerk limit afterwards.
pub(crate) fn coast(before: &RampState, in_a_row: u64, spec: &JointSpec) -> RampState {
    let jerk = if in_a_row > 1 { spec.jerk } else { 0.0 };
    let next = before.coast(jerk, TICK_S);
    let velocity = next.velocity.clamp(-spec.velocity, spec.velocity);
    let is_limited = velocity.to_bits() != next.velocity.to_bits();
    // At the velocity limit the position follows the clamped velocity, or the two would
    // disagree by a step that counts as a violation.
    let next = if is_limited {
        RampState {
            position: before.position + 0.5 * (before.velocity + velocity) * TICK_S,
            velocity,
            acceleration: (velocity - before.velocity) / TICK_S,
        }
    } else {
        next
    };
    RampState {
        position: next.position.clamp(spec.lower, spec.upper),
        acceleration: continuable(next.velocity, next.acceleration, spec),
        ..next
    }
}

/// As much of `acceleration` as the jerk limit can end before `velocity` is at its limit.
// A controller that starts here continues it and keeps both limits. Without this its first
// commands break one of them: the way back to the path keeps the acceleration limit alone.
fn continuable(velocity: f64, acceleration: f64, spec: &JointSpec) -> f64 {
    let forward = acceleration.signum();
    let half = 0.5 * TICK_S;
    // The last reduction is a part of `j t`, which adds up to `j t²/8`.
    let room = spec.velocity - forward * velocity - 0.5 * spec.jerk * half * half;
    // The ticks that reduce `a` by `j t` each add `a²/2j - a t/2`: its positive root.
    let most = spec.jerk * ((half * half + 2.0 * room.max(0.0) / spec.jerk).sqrt() + half);
    acceleration.clamp(-most, most)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> JointSpec {
        JointSpec {
            lower: -2.0,
            upper: 2.0,
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

    /// A path at the acceleration limit: to full speed, back, and rest.
    fn path() -> Vec<RampState> {
        let mut at = RampState::default();
        let mut path = vec![at];
        for tick in 0..1_600 {
            at.acceleration = match tick {
                0..200 | 800..1_000 => 10.0,
                400..800 => -10.0,
                _ => 0.0,
            };
            let velocity = at.velocity + at.acceleration * TICK_S;
            at.position += 0.5 * (at.velocity + velocity) * TICK_S;
            at.velocity = velocity;
            path.push(at);
        }
        path
    }

    #[test]
    fn a_controller_can_continue_from_a_setpoint_that_catches_up_or_coasts() {
        let spec = JointSpec {
            jerk: 500.0,
            ..spec()
        };
        let ahead = RampState {
            position: 1.0,
            velocity: 2.0,
            acceleration: 0.0,
        };
        let mut setpoint = RampState::default();
        for tick in 0..400 {
            setpoint = match tick % 7 {
                0 => coast(&setpoint, 1, &spec),
                _ => catch_up(&setpoint, &ahead, &spec),
            };
            let mut next = setpoint;
            while next.acceleration > 0.0 {
                next = next.coast(spec.jerk, TICK_S);
                assert!(
                    next.velocity <= spec.velocity + 1.0e-9,
                    "{tick}: {setpoint:?}"
                );
            }
        }
        assert!(setpoint.velocity > 1.9, "{setpoint:?}");
    }

    #[test]
    fn missed_commands_never_break_the_acceleration_limit_and_the_path_is_met_again() {
        let (spec, path) = (spec(), path());
        // Every tick, one missed of each three, bursts of five.
        let patterns: [fn(usize) -> bool; 3] =
            [|_| true, |tick| tick % 3 != 0, |tick| tick % 60 >= 5];
        for (index, arrives) in patterns.into_iter().enumerate() {
            let mut setpoint = RampState::default();
            let (mut farthest, mut missed) = (0.0_f64, 0);
            for (tick, commanded) in path.iter().enumerate().skip(1) {
                let before = setpoint;
                let is_late = !arrives(tick) && tick < 1_100;
                setpoint = if is_late {
                    missed += 1;
                    coast(&before, missed, &spec)
                } else {
                    missed = 0;
                    catch_up(&before, commanded, &spec)
                };
                let made = (setpoint.velocity - before.velocity).abs() / TICK_S;
                assert!(
                    made <= spec.acceleration * (1.0 + 1.0e-9),
                    "{index} {tick}: {made}"
                );
                assert!(setpoint.velocity.abs() <= spec.velocity * (1.0 + 1.0e-9));
                farthest = farthest.max((setpoint.position - commanded.position).abs());
            }
            assert_eq!(setpoint, *path.last().unwrap(), "{index}");
            let allowed = [1.0e-12, 5.0e-3, 0.2][index];
            assert!(farthest < allowed, "{index}: {farthest}");
        }
    }
}
