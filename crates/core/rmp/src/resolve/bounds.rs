//! The accelerations of one joint that are allowed in the next step, so that a braking motion
//! within all limits exists afterwards.
//!
//! The accident to prevent: a joint at full speed near a limit, for which each acceleration of
//! the next step breaks position, acceleration or jerk. Time is discrete: the next velocity is
//! `v + a dt`, the next position `q + v dt`. An acceleration is allowed if the sequence that
//! lowers it from then on by `jerk * dt` each step, down to `-acceleration`, keeps velocity
//! and position below their upper limits (mirrored for the lower ones). The next step may
//! always continue this sequence, so the allowed interval never becomes empty once it was not.
//!
//! A change must keep the discrete sums: with the formulas of continuous time the sequence may
//! end beyond the limit by the motion of a step.

/// Limits of one joint, as in [`crate::JointLimits`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limit {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
}

/// Last command of one joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Last {
    pub(crate) position: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
}

/// The limit that makes a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reason {
    Jerk,
    Acceleration,
    Velocity,
    Position,
}

/// One end of the allowed interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bound {
    pub(crate) value: f64,
    pub(crate) reason: Reason,
}

/// Allowed accelerations; `conflict` if no acceleration keeps every limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    pub(crate) low: Bound,
    pub(crate) high: Bound,
    pub(crate) conflict: bool,
}

/// Halvings if a position limit binds: 2^-30 of the jerk interval is left.
// A count, not a tolerance: each call takes the same time and gives the same bits.
const HALVINGS: usize = 30;
/// Largest excess of a braking motion over a position limit by rounding that is not a
/// conflict, rad or m.
const SLACK: f64 = 1e-11;

/// The interval of accelerations allowed in the next step of `dt` seconds. Jerk and
/// acceleration limits always hold; if velocity or position cannot be kept within them (a bad
/// start), the hardest braking is the only choice.
pub(crate) fn allowed(limit: &Limit, last: &Last, dt: f64) -> Interval {
    let (floor, ceiling, mut conflict) = reachable(limit, last, dt);
    // One side is solved; the lower limits are the upper ones of the mirrored joint.
    let high = upper_side(limit, last, dt, floor, ceiling);
    let mirrored = upper_side(
        &limit.mirrored(),
        &last.mirrored(),
        dt,
        ceiling.mirrored(),
        floor.mirrored(),
    );
    let mut interval = Interval {
        low: mirrored.0.mirrored(),
        high: high.0,
        conflict: false,
    };
    conflict |= high.1 || mirrored.1;
    if interval.low.value > interval.high.value {
        conflict = true;
        // Against the motion: the harder braking of the two ends.
        if last.velocity >= 0.0 {
            interval.low = interval.high;
        } else {
            interval.high = interval.low;
        }
    }
    interval.conflict = conflict;
    interval
}

impl Limit {
    fn mirrored(&self) -> Self {
        Self {
            lower: -self.upper,
            upper: -self.lower,
            ..*self
        }
    }
}

impl Last {
    fn mirrored(&self) -> Self {
        Self {
            position: -self.position,
            velocity: -self.velocity,
            acceleration: -self.acceleration,
        }
    }
}

impl Bound {
    fn mirrored(self) -> Self {
        Self {
            value: -self.value,
            ..self
        }
    }
}

/// The interval that jerk and acceleration limits leave.
fn reachable(limit: &Limit, last: &Last, dt: f64) -> (Bound, Bound, bool) {
    let step = limit.jerk * dt;
    let bound = |value: f64, reason: Reason| Bound { value, reason };
    let (down, up) = (last.acceleration - step, last.acceleration + step);
    if down > limit.acceleration || up < -limit.acceleration {
        // Already beyond the limit: return as fast as the jerk limit allows.
        let back = bound(if down > 0.0 { down } else { up }, Reason::Jerk);
        return (back, back, true);
    }
    let low = if down < -limit.acceleration {
        bound(-limit.acceleration, Reason::Acceleration)
    } else {
        bound(down, Reason::Jerk)
    };
    let high = if up > limit.acceleration {
        bound(limit.acceleration, Reason::Acceleration)
    } else {
        bound(up, Reason::Jerk)
    };
    (low, high, false)
}

/// Greatest acceleration that keeps the upper velocity and position limits, and
/// whether even the lowest fails to.
fn upper_side(limit: &Limit, last: &Last, dt: f64, floor: Bound, ceiling: Bound) -> (Bound, bool) {
    let mut high = ceiling;
    let mut failed = false;
    let by_velocity = greatest_gain(limit.velocity - last.velocity, limit.jerk * dt, dt);
    if by_velocity < high.value {
        // An excess of rounding below the floor is not a conflict.
        failed = by_velocity < floor.value - 1e-9 * limit.acceleration;
        high = Bound {
            value: by_velocity.max(floor.value),
            reason: Reason::Velocity,
        };
    }
    // Most joints are far from their limits: one test in place of the halvings.
    if !limit.upper.is_finite() || keeps_position(limit, last, dt, high.value, 0.0) {
        return (high, failed);
    }
    let mut good = floor.value;
    let mut bad = high.value;
    if keeps_position(limit, last, dt, good, 0.0) {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            if keeps_position(limit, last, dt, middle, 0.0) {
                good = middle;
            } else {
                bad = middle;
            }
        }
    } else {
        failed |= !keeps_position(limit, last, dt, good, SLACK);
    }
    let bound = Bound {
        value: good,
        reason: Reason::Position,
    };
    (bound, failed)
}

/// Greatest acceleration after which a velocity `room` below its limit stays there,
/// when each later step lowers the acceleration by `step`.
///
/// Starting with `a` in `[n step, (n + 1) step)` the velocity gains
/// `dt ((n + 1) a - step n (n + 1) / 2)`; this is the inverse.
pub(crate) fn greatest_gain(room: f64, step: f64, dt: f64) -> f64 {
    let rate = room / dt;
    if rate <= 0.0 {
        return rate;
    }
    let n = (0.5 * ((1.0 + 8.0 * rate / step).sqrt() - 1.0)).floor();
    (rate + 0.5 * step * n * (n + 1.0)) / (n + 1.0)
}

/// Whether the braking sequence that starts with `a` stays below the upper limit plus `slack`,
/// or at least does not exceed the next position, which is already decided.
fn keeps_position(limit: &Limit, last: &Last, dt: f64, a: f64, slack: f64) -> bool {
    let next = last.position + last.velocity * dt;
    let farthest = next + dt * climb(limit, last.velocity, dt, a);
    farthest <= next.max(limit.upper + slack)
}

/// Sum of the velocities of the braking sequence up to its last positive one, m/s or rad/s:
/// times dt, the remaining distance.
fn climb(limit: &Limit, velocity: f64, dt: f64, a: f64) -> f64 {
    let step = limit.jerk * dt;
    // While the jerk acts, v_i = v + dt (i a - step i (i - 1) / 2): last i above zero.
    let half = a + 0.5 * step;
    let discriminant = half * half + 2.0 * step * velocity / dt;
    if discriminant < 0.0 {
        return 0.0;
    }
    let turning = ((half + discriminant.sqrt()) / step).floor().max(0.0);
    let ramp = ((a + limit.acceleration) / step).floor() + 1.0;
    let m = turning.min(ramp);
    let ramped =
        m * velocity + dt * (a * m * (m + 1.0) / 2.0 - step * (m - 1.0) * m * (m + 1.0) / 6.0);
    if turning < ramp {
        return ramped;
    }
    let left = velocity + dt * (m * a - step * m * (m - 1.0) / 2.0);
    let drop = limit.acceleration * dt;
    let rest = (left / drop).floor().max(0.0);
    ramped + rest * left - drop * rest * (rest + 1.0) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const PANDA_2: Limit = Limit {
        lower: -1.7628,
        upper: 1.7628,
        velocity: 2.175,
        acceleration: 7.5,
        jerk: 3750.0,
    };
    const UR10: Limit = Limit {
        lower: -3.0,
        upper: 3.0,
        velocity: 2.0,
        acceleration: 12.0,
        jerk: 500.0,
    };

    /// Drives with `choose` for 3 s and checks every limit on the way.
    fn drive(limit: &Limit, dt: f64, mut choose: impl FnMut(&Interval, usize) -> f64) -> Last {
        let mut last = Last {
            position: 0.0,
            velocity: 0.0,
            acceleration: 0.0,
        };
        for step in 0..3000 {
            let interval = allowed(limit, &last, dt);
            assert!(!interval.conflict, "step {step}: {last:?}");
            let a = choose(&interval, step);
            let velocity = last.velocity + a * dt;
            let quotient = (velocity - last.velocity) / dt;
            let jerk = (quotient - last.acceleration) / dt;
            assert!(velocity.abs() <= limit.velocity * (1.0 + 1e-6));
            assert!(quotient.abs() <= limit.acceleration * (1.0 + 1e-6));
            assert!(jerk.abs() <= limit.jerk * (1.0 + 1e-6));
            last = Last {
                position: last.position + last.velocity * dt,
                velocity,
                acceleration: quotient,
            };
            assert!(last.position <= limit.upper + 1e-8);
            assert!(last.position >= limit.lower - 1e-8);
        }
        last
    }

    #[test]
    fn pushing_at_a_position_limit_stops_at_it() {
        for limit in [PANDA_2, UR10] {
            for dt in [0.001, 0.002] {
                let end = drive(&limit, dt, |i, _| i.high.value);
                assert!((limit.upper - end.position).abs() < 1e-3, "{end:?}");
                assert!(end.velocity.abs() < 0.02);
                let end = drive(&limit, dt, |i, _| i.low.value);
                assert!((limit.lower - end.position).abs() < 1e-3, "{end:?}");
            }
        }
    }

    #[test]
    fn any_choice_within_the_interval_keeps_every_limit() {
        for (limit, period) in [(PANDA_2, 7), (PANDA_2, 311), (UR10, 97), (UR10, 613)] {
            let mut seed = 9_u64;
            drive(&limit, 0.001, |interval, step| {
                seed = seed
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                let share = (seed >> 11) as f64 / (1_u64 << 53) as f64;
                let towards = if step / period % 2 == 0 {
                    share.sqrt()
                } else {
                    share * share
                };
                let (low, high) = (interval.low.value, interval.high.value);
                low + (high - low) * towards
            });
        }
    }

    #[test]
    fn a_start_that_cannot_be_kept_brakes_and_says_so() {
        let last = Last {
            position: 1.75,
            velocity: 2.0,
            acceleration: 0.0,
        };
        let interval = allowed(&PANDA_2, &last, 0.001);
        assert!(interval.conflict);
        assert_eq!(interval.high.value, -3.75);
        assert_eq!(interval.high.reason, Reason::Position);
    }

    #[test]
    fn a_start_outside_a_limit_may_come_back_gently_but_not_go_out() {
        let last = Last {
            position: 1.8,
            velocity: 0.0,
            acceleration: 0.0,
        };
        let interval = allowed(&PANDA_2, &last, 0.001);
        assert!(interval.high.value < 1e-4, "{interval:?}");
        assert!(interval.low.value < -1.0);
    }
}
