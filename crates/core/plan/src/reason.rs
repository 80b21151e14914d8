//! The reason why an arm at rest is not at its target.

use rmp::JointLimits;

use crate::check::{Checker, distance};
use crate::ik::{Found, Tool};
use crate::planner::Settings;
use crate::to_pose::Request;

/// Least motion of the tool below which it cannot move in some direction (m/rad, rad/rad).
const SINGULAR: f64 = 0.03;
/// Distance of a joint from its limit at which it is at the limit (rad or m).
const AT_LIMIT: f64 = 0.05;

/// The reason why an arm does not reach its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// No joint positions have the pose.
    Unreachable,
    /// All joint positions with the pose are beyond a limit, or a joint is at its limit on the
    /// way.
    JointLimit,
    /// An obstacle or the arm itself is at the target or on the way.
    Blocked,
    /// The arm is stretched or folded so that the tool cannot move on.
    Singular,
    /// No other reason applies: the motion policies balance each other.
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

/// The reason why the arm of `request`, at rest at its start, does not move `tool` to the
/// goal.
pub fn reason(request: &Request<'_>, tool: &mut Tool<'_>, settings: &Settings) -> Reason {
    let mut goals = Vec::new();
    for start in request.starts(settings) {
        goals.extend(tool.solve(&start, request.goal).filter(Found::is_met));
    }
    if goals.is_empty() {
        return if is_beyond_a_limit(request, tool, settings) {
            Reason::JointLimit
        } else {
            Reason::Unreachable
        };
    }
    // Motion policies move towards the nearest one.
    let off = |goal: &Found| distance(&goal.positions, request.start);
    let nearest = goals.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    let mut checker = Checker::new(request.body, request.scene, settings.resolution);
    // The order matters: each reason is tested only where the ones before it do not apply.
    let is_free = nearest.is_some_and(|goal| checker.is_edge_free(request.start, &goal.positions));
    if !is_free {
        Reason::Blocked
    } else if tool.least_motion(request.start) < SINGULAR {
        Reason::Singular
    } else if is_at_a_limit(request.start, tool.limits()) {
        Reason::JointLimit
    } else {
        Reason::LocalMinimum
    }
}

/// Whether the pose is met with limits that are a turn (m) wider on each side.
fn is_beyond_a_limit(request: &Request<'_>, tool: &mut Tool<'_>, settings: &Settings) -> bool {
    let turn = std::f64::consts::TAU;
    let wide = |limits: &[f64], by: f64| limits.iter().map(|limit| limit + by).collect();
    let limits = JointLimits {
        lower: wide(&tool.limits().lower, -turn),
        upper: wide(&tool.limits().upper, turn),
        ..tool.limits().clone()
    };
    let mut beyond = tool.within(&limits);
    let mut starts = request.starts(settings);
    starts.any(|start| {
        let found = beyond.solve(&start, request.goal);
        found.is_some_and(|found| found.is_met())
    })
}

fn is_at_a_limit(positions: &[f64], limits: &JointLimits) -> bool {
    let limits = limits.lower.iter().zip(&limits.upper);
    let mut joints = positions.iter().zip(limits);
    joints.any(|(at, (lower, upper))| at - lower < AT_LIMIT || upper - at < AT_LIMIT)
}
