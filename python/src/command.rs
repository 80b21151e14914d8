//! Commands for an arm.

use ipc_types::{GripperGoal, MAX_JOINTS, Pose};
use pyo3::prelude::*;
use robocell_skills::World;
use robocell_task::{ArmIntent, GoalKind};
use serde::{Deserialize, Serialize};

use crate::decision::Decision;
use crate::work::{Status, Work};

/// A target nearer than this to the one before is the same goal, moved (m).
const SAME_GOAL_M: f64 = 0.05;
/// Number of the joint-space PD controller, which sees no obstacles.
const JOINT_PD: u32 = cell_sim::controller_proc::controllers::JOINT_PD;

/// A command for an arm: in a decision for 10 ms, from outside of decisions until the next
/// command.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) enum Command {
    /// The TCP to a pose.
    Pose(PoseCommand),
    /// The joints to positions.
    Joints {
        positions: Vec<f64>,
        gripper: u32,
        /// Past obstacles, by RMPflow; else straight, by the joint controller.
        avoids: bool,
    },
    /// The gripper; the arm stays where it was sent.
    Grip(u32),
    /// No motion.
    Hold,
    /// The steps of a skill; how it ended.
    Skill(Box<Work>, Option<Status>),
}

/// Part of [`Command::Pose`].
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct PoseCommand {
    pub(crate) position_m: [f64; 3],
    /// Of unit length.
    pub(crate) orientation_wxyz: [f64; 4],
    pub(crate) gripper: u32,
    pub(crate) approach_m: [f64; 3],
    pub(crate) approach_std_dev_m: f64,
    pub(crate) object_mask: u64,
    pub(crate) obstacle_mask: u64,
    pub(crate) posture: Option<Vec<f64>>,
}

impl Command {
    /// Gives the command of this decision to an arm.
    ///
    /// # Errors
    /// For a skill with a name that the cell does not have.
    pub(crate) fn give(&mut self, decision: &mut Decision, arm: usize) -> PyResult<()> {
        match self {
            Self::Pose(pose) => decision.world(arm, |world| pose.give(world)),
            Self::Joints {
                positions,
                gripper,
                avoids,
            } => {
                let selector = if *avoids { 0 } else { JOINT_PD };
                decision.world(arm, |world| joints(world, positions, *gripper, selector));
            }
            Self::Grip(gripper) => decision.world(arm, |world| world.stay(goal(*gripper))),
            Self::Hold => decision.world(arm, |world| world.hold()),
            Self::Skill(skill, ended @ (None | Some(Status::RUNNING))) => {
                *ended = Some(skill.step(decision, arm)?);
            }
            // It has ended: an arm without a command stays where it is, see `Decision::end`.
            Self::Skill(..) => {}
        }
        Ok(())
    }
}

impl PoseCommand {
    fn give(&self, world: &mut World<'_>) {
        let target = Pose {
            position: self.position_m,
            orientation_wxyz: self.orientation_wxyz,
        };
        let key = pose_key(world, &target);
        world.act(ArmIntent {
            gripper: goal(self.gripper),
            approach: self.approach_m,
            approach_std_dev: self.approach_std_dev_m,
            obstacle_mask: self.obstacle_mask,
            object_mask: self.object_mask,
            posture: self.posture.as_deref().map(padded),
            ..ArmIntent::pose(key, target)
        });
    }
}

fn joints(world: &mut World<'_>, positions: &[f64], gripper: u32, selector: u32) {
    // A new key in each decision would be a new goal every 10 ms.
    let key = match world.out.previous(world.arm) {
        Some(told) if told.kind == GoalKind::Joints => told.key,
        _ => world.new_key(),
    };
    world.act(ArmIntent {
        kind: GoalKind::Joints,
        key,
        selector,
        gripper: goal(gripper),
        posture: Some(padded(positions)),
        target: world.tcp().unwrap_or(Pose::IDENTITY),
        ..ArmIntent::default()
    });
}

fn padded(positions: &[f64]) -> [f64; MAX_JOINTS] {
    let mut all = [0.0; MAX_JOINTS];
    all.iter_mut()
        .zip(positions)
        .for_each(|(slot, x)| *slot = *x);
    all
}

fn goal(code: u32) -> GripperGoal {
    // Only a snapshot of another version has another code; then the gripper keeps its command.
    GripperGoal::from_code(code).unwrap_or(GripperGoal::Keep)
}

/// The key of the goal that is followed, if `target` only moves it; else a new one.
fn pose_key(world: &mut World<'_>, target: &Pose) -> u64 {
    let near = |a: [f64; 3], b: [f64; 3]| {
        let off: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
        off < SAME_GOAL_M * SAME_GOAL_M
    };
    match world.out.previous(world.arm) {
        Some(told)
            if told.kind == GoalKind::Pose && near(told.target.position, target.position) =>
        {
            told.key
        }
        _ => world.new_key(),
    }
}
