//! The resolve of a real robot: the acceleration nearest to the wanted one in the
//! metric, within what position, velocity, acceleration and jerk limits allow.

use super::bounds::{Bound, Interval, Last, Limit, Reason, allowed, greatest_gain};
use super::box_qp::BoxQp;
use crate::{JointLimits, MotionState, Root};

/// Limits that were active in a step; bit `i` is controlled joint `i`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ClipFlags {
    /// Braking ahead of a position limit.
    pub position: u64,
    /// Staying below the velocity limit.
    pub velocity: u64,
    /// At the acceleration limit.
    pub acceleration: u64,
    /// At the jerk limit.
    pub jerk: u64,
    /// No acceleration kept every limit (a bad start): hardest braking was taken.
    pub conflict: u64,
}

impl ClipFlags {
    /// Whether no limit was active.
    pub fn is_clear(&self) -> bool {
        *self == Self::default()
    }

    fn mark(&mut self, reason: Reason, bit: u64) {
        match reason {
            Reason::Position => self.position |= bit,
            Reason::Velocity => self.velocity |= bit,
            Reason::Acceleration => self.acceleration |= bit,
            Reason::Jerk => self.jerk |= bit,
        }
    }
}

/// Least ratio of jerk to acceleration limit (1/s). Motion policies request accelerations that
/// change as fast as their damping gains, about 100 1/s. If the jerk limit delays them too
/// much, the arm swings around its target (measured below 20 1/s). A lower acceleration is
/// reached sooner, so a joint with a low jerk limit gets a lower acceleration limit.
const LEAST_JERK_RATIO: f64 = 60.0;
/// Longest time to brake from full speed at full acceleration (s): a joint that cannot brake
/// in less is slower, since policies do not look farther ahead.
const LONGEST_BRAKING_S: f64 = 1.0;

/// Preallocated box and solver.
#[derive(Debug, Clone)]
pub(crate) struct CellResolve {
    /// Speed that no joint exceeds (rad/s or m/s).
    velocity_cap: f64,
    intervals: Vec<Interval>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    qp: BoxQp,
}

impl CellResolve {
    pub(crate) fn new(joints: usize, velocity_cap: f64) -> Self {
        let zero = Bound {
            value: 0.0,
            reason: Reason::Jerk,
        };
        let interval = Interval {
            low: zero,
            high: zero,
            conflict: false,
        };
        Self {
            velocity_cap,
            intervals: vec![interval; joints],
            lower: vec![0.0; joints],
            upper: vec![0.0; joints],
            qp: BoxQp::new(joints),
        }
    }

    /// See [`crate::RmpFlow::active_bounds`].
    pub(crate) fn active_bounds(&self) -> (u64, u64) {
        self.qp.active_bounds()
    }

    /// See [`crate::RmpFlow::set_active_bounds`].
    pub(crate) fn set_active_bounds(&mut self, lower: u64, upper: u64) {
        self.qp.set_active_bounds(lower, upper);
    }

    /// Writes the acceleration to `out`; `false` if the metric was singular and the joints
    /// brake instead.
    pub(crate) fn resolve(
        &mut self,
        root: &Root,
        state: &MotionState,
        limits: &JointLimits,
        dt: f64,
        out: &mut [f64],
    ) -> (ClipFlags, bool) {
        // Bounds first, per joint; the metric then decides how joints share what is left. A
        // clamp per joint after the resolve cost clearance: 13.7 in place of 22.3 mm among ten
        // obstacles.
        for i in 0..out.len() {
            let limit = self.followed(limit_of(limits, i));
            let interval = allowed(&limit, &last_of(state, i), dt);
            self.lower[i] = interval.low.value;
            self.upper[i] = interval.high.value;
            self.intervals[i] = interval;
        }
        let solved = self
            .qp
            .solve(&root.metric, &root.force, &self.lower, &self.upper, out);
        // A singular metric has no direction to follow: the arm brakes within its limits.
        if !solved {
            for (i, (a, interval)) in out.iter_mut().zip(&self.intervals).enumerate() {
                *a = braking(&limit_of(limits, i), &last_of(state, i), interval, dt);
            }
        }
        (flags(&self.intervals, out), solved)
    }

    /// The part of `limit` in which motion policies are stable.
    fn followed(&self, limit: Limit) -> Limit {
        let acceleration = limit.acceleration.min(limit.jerk / LEAST_JERK_RATIO);
        let stoppable = acceleration * LONGEST_BRAKING_S;
        Limit {
            velocity: limit.velocity.min(self.velocity_cap).min(stoppable),
            acceleration,
            ..limit
        }
    }
}

/// Brakes every joint to rest as fast as `limits` allow, without reversing, and
/// integrates `state` by `dt` seconds. Returns the limits that were active.
///
/// # Errors
/// [`crate::SetupError`] or [`crate::LimitsError`] through
/// [`crate::FlowError`] where lengths or numbers cannot be used; `state` is left
/// as it is.
pub fn brake(
    state: &mut MotionState,
    limits: &JointLimits,
    dt: f64,
) -> Result<ClipFlags, crate::FlowError> {
    let joints = state.positions.len();
    // All checks before the first change: a refused step leaves the state as it was.
    state.check(joints)?;
    limits.validate(joints)?;
    crate::state::check_dt(dt)?;
    let mut found = ClipFlags::default();
    for i in 0..joints {
        let (limit, last) = (limit_of(limits, i), last_of(state, i));
        let interval = allowed(&limit, &last, dt);
        let a = braking(&limit, &last, &interval, dt);
        mark_joint(&mut found, &interval, a, i);
        state.positions[i] += state.velocities[i] * dt;
        state.velocities[i] += a * dt;
        state.accelerations[i] = a;
    }
    Ok(found)
}

/// Accelerates every joint as `wanted` (rad/s² or m/s²) as far as `limits` allow, and
/// integrates `state` by `dt` seconds. Returns the limits that were active.
///
/// # Errors
/// As [`brake`].
pub fn follow(
    state: &mut MotionState,
    limits: &JointLimits,
    wanted: &[f64],
    dt: f64,
) -> Result<ClipFlags, crate::FlowError> {
    let joints = state.positions.len();
    state.check(joints)?;
    crate::state::check_values("wanted accelerations", wanted, joints)?;
    limits.validate(joints)?;
    crate::state::check_dt(dt)?;
    let mut found = ClipFlags::default();
    for (i, wanted) in wanted.iter().enumerate() {
        let interval = allowed(&limit_of(limits, i), &last_of(state, i), dt);
        let a = wanted.max(interval.low.value).min(interval.high.value);
        mark_joint(&mut found, &interval, a, i);
        state.positions[i] += state.velocities[i] * dt;
        state.velocities[i] += a * dt;
        state.accelerations[i] = a;
    }
    Ok(found)
}

/// Acceleration that takes the velocity to zero without crossing it.
fn braking(limit: &Limit, last: &Last, interval: &Interval, dt: f64) -> f64 {
    let step = limit.jerk * dt;
    let wanted = -greatest_gain(last.velocity.abs(), step, dt).copysign(last.velocity);
    wanted.max(interval.low.value).min(interval.high.value)
}

fn flags(intervals: &[Interval], accelerations: &[f64]) -> ClipFlags {
    let mut found = ClipFlags::default();
    for (i, (interval, &a)) in intervals.iter().zip(accelerations).enumerate() {
        mark_joint(&mut found, interval, a, i);
    }
    found
}

fn mark_joint(found: &mut ClipFlags, interval: &Interval, a: f64, joint: usize) {
    let bit = 1_u64 << joint;
    if a >= interval.high.value {
        found.mark(interval.high.reason, bit);
    }
    if a <= interval.low.value {
        found.mark(interval.low.reason, bit);
    }
    if interval.conflict {
        found.conflict |= bit;
    }
}

fn limit_of(limits: &JointLimits, joint: usize) -> Limit {
    Limit {
        lower: limits.lower[joint],
        upper: limits.upper[joint],
        velocity: limits.velocity[joint],
        acceleration: limits.acceleration[joint],
        jerk: limits.jerk[joint],
    }
}

fn last_of(state: &MotionState, joint: usize) -> Last {
    Last {
        position: state.positions[joint],
        velocity: state.velocities[joint],
        acceleration: state.accelerations[joint],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn braking_stops_within_the_limits_and_stays() {
        let limits = JointLimits {
            lower: vec![-3.0],
            upper: vec![3.0],
            velocity: vec![2.0],
            acceleration: vec![12.0],
            jerk: vec![500.0],
        };
        for acceleration in [-12.0, -3.0, 0.0, 5.0, 12.0] {
            let mut state = MotionState {
                positions: vec![0.0],
                velocities: vec![1.3],
                accelerations: vec![acceleration],
            };
            for _ in 0..400 {
                let (v, a) = (state.velocities[0], state.accelerations[0]);
                brake(&mut state, &limits, 0.001).unwrap();
                let now = (state.velocities[0] - v) / 0.001;
                assert!(now.abs() <= 12.0 * (1.0 + 1e-6));
                assert!((now - a).abs() <= 0.5 * (1.0 + 1e-6));
                assert!(state.velocities[0] > -1e-9);
            }
            assert!(state.velocities[0].abs() < 1e-9, "{state:?}");
            assert!(state.accelerations[0].abs() < 1e-6, "{state:?}");
        }
    }
}
