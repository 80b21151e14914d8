//! Why an arm at rest is not at its target.

use nalgebra::{DMatrix, Isometry3};
use rmp::{JointLimits, RmpFlow, TargetId};

use crate::check::{Checker, distance};
use crate::ik::Tool;
use crate::planner::Settings;
use crate::to_pose::starts;
use crate::{Body, Scene};

/// Below this the tool cannot move in some direction (m/rad, rad/rad).
const SINGULAR: f64 = 0.03;
/// A joint nearer to its limit is at it (rad or m).
const AT_LIMIT: f64 = 0.05;

/// What keeps an arm from its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// No joint positions bring the tool there.
    Unreachable,
    /// Those that do are beyond a limit, or a joint is at its limit on the way.
    JointLimit,
    /// Something is at the target or on the way, an obstacle or the arm itself.
    Blocked,
    /// The arm is stretched or folded so that the tool cannot move on.
    Singular,
    /// None of these: the motion policies hold each other off.
    LocalMinimum,
}

impl Reason {
    /// Stable name, for programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unreachable => "unreachable",
            Self::JointLimit => "joint_limit",
            Self::Blocked => "blocked",
            Self::Singular => "singular",
            Self::LocalMinimum => "local_minimum",
        }
    }
}

/// The arm and what it does.
#[derive(Debug, Clone, Copy)]
pub struct Stuck<'a> {
    /// The arm.
    pub body: &'a Body,
    /// What is around it.
    pub scene: &'a Scene,
    /// Its limits.
    pub limits: &'a JointLimits,
    /// Where it is (rad or m).
    pub at: &'a [f64],
    /// One it likes (rad or m).
    pub posture: &'a [f64],
    /// Where the tool is to be, base frame.
    pub goal: &'a Isometry3<f64>,
}

/// Why the arm of `stuck` does not move its tool, a target frame of `flow`, to the goal. The
/// kinematics of `flow` are anywhere afterwards.
pub fn reason(
    stuck: &Stuck<'_>,
    flow: &mut RmpFlow,
    tool: TargetId,
    settings: &Settings,
) -> Reason {
    let mut checker = Checker::new(stuck.body, stuck.scene, settings.resolution);
    let mut goals = Vec::new();
    let mut within = Tool::new(flow, tool, stuck.limits);
    for start in starts(stuck.body, (stuck.at, stuck.posture), settings) {
        goals.extend(
            within
                .solve(&start, stuck.goal)
                .filter(crate::Found::is_met),
        );
    }
    if goals.is_empty() {
        return if is_beyond_a_limit(stuck, flow, tool, settings) {
            Reason::JointLimit
        } else {
            Reason::Unreachable
        };
    }
    // Motion policies move towards the nearest one.
    let off = |goal: &crate::Found| distance(&goal.positions, stuck.at);
    let nearest = goals.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    let is_free = nearest.is_some_and(|goal| checker.is_edge_free(stuck.at, &goal.positions));
    if !is_free {
        return Reason::Blocked;
    }
    if least_motion(stuck, flow, tool) < SINGULAR {
        return Reason::Singular;
    }
    if is_at_a_limit(stuck) {
        return Reason::JointLimit;
    }
    Reason::LocalMinimum
}

/// Whether joints without limits have the pose.
fn is_beyond_a_limit(
    stuck: &Stuck<'_>,
    flow: &mut RmpFlow,
    tool: TargetId,
    settings: &Settings,
) -> bool {
    let turn = std::f64::consts::TAU;
    let wide = |limits: &[f64], by: f64| limits.iter().map(|limit| limit + by).collect();
    let limits = JointLimits {
        lower: wide(&stuck.limits.lower, -turn),
        upper: wide(&stuck.limits.upper, turn),
        ..stuck.limits.clone()
    };
    let mut beyond = Tool::new(flow, tool, &limits);
    let mut starts = starts(stuck.body, (stuck.at, stuck.posture), settings);
    starts.any(|start| {
        let found = beyond.solve(&start, stuck.goal);
        found.is_some_and(|found| found.is_met())
    })
}

/// How much the tool moves in its worst direction with the best motion of length one: the
/// least singular value of its Jacobian.
fn least_motion(stuck: &Stuck<'_>, flow: &mut RmpFlow, tool: TargetId) -> f64 {
    let mut jacobian = DMatrix::zeros(6, flow.joint_count());
    let posed = flow.target_frame_pose_at(tool, stuck.at).is_ok();
    if !posed || flow.target_frame_jacobian(tool, &mut jacobian).is_err() {
        return f64::INFINITY;
    }
    jacobian.singular_values().min()
}

fn is_at_a_limit(stuck: &Stuck<'_>) -> bool {
    let limits = stuck.limits.lower.iter().zip(&stuck.limits.upper);
    let mut joints = stuck.at.iter().zip(limits);
    joints.any(|(at, (lower, upper))| at - lower < AT_LIMIT || upper - at < AT_LIMIT)
}
