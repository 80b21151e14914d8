//! Joint positions at which a tool has a pose: damped least squares (Nakamura and Hanafusa,
//! 1986) from several starts.

use nalgebra::{DMatrix, Isometry3, Matrix6, Vector6};
use rmp::{JointLimits, RmpFlow, TargetId};

use crate::halton;

/// Largest number of steps from one start.
const STEPS: usize = 120;
/// Damping, in the units of the Jacobian: keeps a step near a singularity finite.
const DAMPING: f64 = 0.02;
/// Longest step of a joint (rad or m).
// Longer steps leave the range in which the Jacobian describes the motion.
const LONGEST_STEP: f64 = 0.3;
/// Starts of a search besides the given ones.
const SPREAD: u64 = 16;
/// Starts of a joint without a limit, or with one beyond this, are within it (rad or m).
// A full turn to each side has every orientation of the joint.
const WIDEST: f64 = std::f64::consts::TAU;
/// Distance at which a pose is met (m, rad).
const MET_M: f64 = 1.0e-4;
const MET_RAD: f64 = 1.0e-3;

/// The inverse kinematics of one tool.
#[derive(Debug)]
pub struct Tool<'a> {
    flow: &'a mut RmpFlow,
    frame: TargetId,
    limits: &'a JointLimits,
    jacobian: DMatrix<f64>,
}

/// Joint positions, and their distance from a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// rad or m.
    pub positions: Vec<f64>,
    /// Distance of the tool from the pose (m).
    pub off_m: f64,
    /// Angle between tool and pose (rad).
    pub off_rad: f64,
}

impl Found {
    /// Whether the pose is met.
    pub fn is_met(&self) -> bool {
        self.off_m < MET_M && self.off_rad < MET_RAD
    }

    /// The nearer of two, where 1 rad counts as 1 m; of equals the first.
    pub(crate) fn nearer(best: Option<Self>, other: Self) -> Self {
        match best {
            Some(best) if best.off_m + best.off_rad <= other.off_m + other.off_rad => best,
            _ => other,
        }
    }
}

impl<'a> Tool<'a> {
    /// The inverse kinematics of a target frame of `flow`, whose joints have `limits`. The
    /// kinematics of `flow` are left at an arbitrary state.
    pub fn new(flow: &'a mut RmpFlow, tool: TargetId, limits: &'a JointLimits) -> Self {
        let jacobian = DMatrix::zeros(6, flow.joint_count());
        Self {
            flow,
            frame: tool,
            limits,
            jacobian,
        }
    }

    /// The same tool with other joint limits.
    pub(crate) fn within<'b>(&'b mut self, limits: &'b JointLimits) -> Tool<'b> {
        Tool::new(self.flow, self.frame, limits)
    }

    /// The limits of its joints.
    pub(crate) fn limits(&self) -> &'a JointLimits {
        self.limits
    }

    /// Least singular value of the Jacobian at `at`: the motion of the tool in its worst
    /// direction for a joint motion of length one. Infinite if `at` is not a configuration of
    /// the robot.
    pub(crate) fn least_motion(&mut self, at: &[f64]) -> f64 {
        let posed = self.flow.target_frame_pose_at(self.frame, at).is_ok();
        let jacobian = &mut self.jacobian;
        if !posed
            || self
                .flow
                .target_frame_jacobian(self.frame, jacobian)
                .is_err()
        {
            return f64::INFINITY;
        }
        jacobian.singular_values().min()
    }

    /// Joint positions within the limits, found from `start` (rad or m), at which the tool is
    /// at `goal` (base frame), or else the nearest ones found; `None` if `start` is not a
    /// configuration of the robot.
    pub fn solve(&mut self, start: &[f64], goal: &Isometry3<f64>) -> Option<Found> {
        let mut at = start.to_vec();
        self.clamp(&mut at);
        let mut best: Option<Found> = None;
        for _ in 0..STEPS {
            let (error, found) = self.error(&at, goal)?;
            if found.is_met() {
                return Some(found);
            }
            // The steps do not always approach: near a limit the last one may be farther than
            // an earlier one.
            best = Some(Found::nearer(best, found));
            self.step(&mut at, &error)?;
        }
        best
    }

    /// As [`Tool::solve`], from each of `near` and then from configurations spread over the
    /// limits, until the pose is met; else the nearest result.
    pub fn search(&mut self, near: &[&[f64]], goal: &Isometry3<f64>) -> Option<Found> {
        let limits = self.limits;
        let spread = |index: u64| -> Vec<f64> {
            let joints = limits.lower.iter().zip(&limits.upper).enumerate();
            let position = |(joint, (low, high)): (usize, (&f64, &f64))| {
                let (low, high) = (low.max(-WIDEST), high.min(WIDEST));
                low + halton::value(index + 1, joint) * (high - low)
            };
            joints.map(position).collect()
        };
        let given = near.iter().map(|start| start.to_vec());
        let mut best: Option<Found> = None;
        for start in given.chain((0..SPREAD).map(spread)) {
            match self.solve(&start, goal) {
                Some(found) if found.is_met() => return Some(found),
                Some(found) => best = Some(Found::nearer(best, found)),
                None => {}
            }
        }
        best
    }

    /// The error to the goal: linear (m), then angular (rad).
    fn error(&mut self, at: &[f64], goal: &Isometry3<f64>) -> Option<(Vector6<f64>, Found)> {
        let pose = self.flow.target_frame_pose_at(self.frame, at).ok()??;
        let off = goal.translation.vector - pose.translation.vector;
        let turn = pose.rotation.rotation_to(&goal.rotation).scaled_axis();
        let found = Found {
            positions: at.to_vec(),
            off_m: off.norm(),
            off_rad: turn.norm(),
        };
        let error = Vector6::new(off.x, off.y, off.z, turn.x, turn.y, turn.z);
        Some((error, found))
    }

    fn step(&mut self, at: &mut [f64], error: &Vector6<f64>) -> Option<()> {
        let jacobian = &mut self.jacobian;
        self.flow.target_frame_jacobian(self.frame, jacobian).ok()?;
        let mut square = Matrix6::identity() * (DAMPING * DAMPING);
        for column in jacobian.column_iter() {
            let column = column.fixed_rows::<6>(0);
            square += column * column.transpose();
        }
        let weights = square.cholesky()?.solve(error);
        let steps: Vec<f64> = jacobian.column_iter().map(|c| c.dot(&weights)).collect();
        let longest = steps
            .iter()
            .fold(LONGEST_STEP, |most, step| most.max(step.abs()));
        // All joints are shortened by one factor: the direction of the step remains.
        for (position, step) in at.iter_mut().zip(steps) {
            *position += step * LONGEST_STEP / longest;
        }
        self.clamp(at);
        Some(())
    }

    fn clamp(&self, at: &mut [f64]) {
        let limits = self.limits.lower.iter().zip(&self.limits.upper);
        for (position, (lower, upper)) in at.iter_mut().zip(limits) {
            *position = position.max(*lower).min(*upper);
        }
    }
}
