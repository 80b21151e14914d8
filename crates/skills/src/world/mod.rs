//! One arm of a cell in one decision: what it sees, and what it is told.

mod drive;
mod seen;
mod surroundings;
mod told;

use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_task::job::Job;
use robocell_task::{Observation, Output, PolicyTime};
use serde::{Deserialize, Serialize};

use crate::setup::{ArmSetup, ObjectSetup, Setup, Tool};

pub use drive::Drive;

/// A controller that was silent for longer does not work (ticks of 1 ms).
const ECHO_LIMIT_TICKS: u64 = 100;

/// What a policy of several arms remembers of each: a [`Job`] remembers one arm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArmMemory {
    /// Key of the newest goal.
    pub newest_key: u64,
    /// Object in the gripper.
    pub held: Option<usize>,
}

impl ArmMemory {
    /// Whether it can belong to a cell with so many objects.
    pub(crate) fn is_sound(&self, objects: usize) -> bool {
        self.newest_key < u64::MAX / 2 && self.held.is_none_or(|held| held < objects)
    }
}

/// What an arm was told so far in one decision, for a view that is made again within
/// the decision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Told {
    acted: bool,
    gripper: GripperGoal,
}

/// The view of one arm in one decision.
pub struct World<'w> {
    /// The cell.
    pub setup: &'w Setup,
    /// What is seen.
    pub observation: &'w Observation<'w>,
    /// What happened so far.
    pub job: &'w mut Job,
    /// Where goals and the log go.
    pub out: &'w mut Output,
    /// Index of the arm.
    pub arm: usize,
    /// Whether this is the first decision after others were missed, or after the
    /// operator led the arm: what skills timed before it counts no more.
    pub resumed: bool,
    /// Of a policy of several arms. Without it the job counts the goals, and knows
    /// what the first arm holds.
    pub memory: Option<&'w mut ArmMemory>,
    /// What the arm was told so far in this decision.
    pub told: Told,
}

impl<'w> World<'w> {
    /// The view of `arm`.
    pub fn new(
        setup: &'w Setup,
        observation: &'w Observation<'w>,
        job: &'w mut Job,
        out: &'w mut Output,
        arm: usize,
    ) -> Self {
        Self {
            setup,
            observation,
            job,
            out,
            arm,
            resumed: false,
            memory: None,
            told: Told::default(),
        }
    }

    /// Policy time.
    pub fn now(&self) -> PolicyTime {
        self.observation.time()
    }

    /// The arm's part of the setup; `None` for an arm the cell does not have.
    pub fn arm_setup(&self) -> Option<&'w ArmSetup> {
        self.setup.arms.get(self.arm)
    }

    /// Whether the arm is wound up, see [`ArmSetup::is_wound`].
    pub fn is_wound(&self) -> bool {
        let seen = self.observation.arm(self.arm);
        let joints = seen.map(|arm| arm.joint_positions);
        let setup = self.arm_setup();
        setup
            .zip(joints)
            .is_some_and(|(setup, at)| setup.is_wound(&at))
    }

    /// Name of the arm, for logs.
    pub fn arm_name(&self) -> &'w str {
        self.arm_setup().map_or("?", |arm| arm.name.as_str())
    }

    /// Whether the arm is seen, has no fault, and its controller answers.
    pub fn is_alive(&self) -> bool {
        let heard = self.observation.echo(self.arm).is_some_and(|echo| {
            self.observation.sample_id().saturating_sub(echo.tick) <= ECHO_LIMIT_TICKS
        });
        let arm = self.observation.arm(self.arm);
        heard && arm.is_some_and(|arm| arm.fault == 0)
    }

    /// What the arm grips with.
    pub fn tool(&self) -> Tool {
        self.arm_setup().map_or(Tool::None, |arm| arm.tool)
    }

    /// Measured TCP, world frame.
    pub fn tcp(&self) -> Option<Pose> {
        self.observation.tcp(self.arm)
    }

    /// Measured position of the TCP (m); the origin for an arm that is not seen.
    pub fn tcp_position(&self) -> Vector3<f64> {
        self.tcp()
            .map_or_else(Vector3::zeros, |tcp| tcp.position.into())
    }

    /// Turn of the measured tool about the vertical axis (rad).
    pub fn tool_yaw(&self) -> f64 {
        let tcp = self.tcp();
        tcp.map_or(0.0, |tcp| self.tool().yaw(tcp.orientation_wxyz))
    }

    /// A key for a new goal.
    pub fn new_key(&mut self) -> u64 {
        let newest = match &mut self.memory {
            Some(memory) => &mut memory.newest_key,
            None => &mut self.job.newest_key,
        };
        *newest += 1;
        *newest
    }

    pub(crate) fn object_setup(&self, object: usize) -> Option<&'w ObjectSetup> {
        self.setup.objects.get(object)
    }
}
