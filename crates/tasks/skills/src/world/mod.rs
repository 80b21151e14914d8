//! One arm of a cell in one decision: its observation, and its commands.
//!
//! Every skill, condition and node works through this view, so its rules are those of all jobs:
//!
//! - One decision, one command. [`World::act`] replaces an earlier command of the same
//!   decision, except for the gripper, whose last command is kept: a node that only moves the
//!   arm must not open the fingers.
//! - [`World::finish`] has to be called at the end of each decision of an arm. An arm without a
//!   command keeps its target; without the call it would have no goal, and a drop would not be
//!   counted.
//! - The arm has arrived only if its controller answered this very goal
//!   ([`World::is_followed`]). The measured pose alone would accept an arm that passes its
//!   target on the way to an older goal, and the echo alone one that has not moved yet.
//! - Whether an object is held is observed ([`World::held`]), never remembered: people take
//!   objects away, and a restored task must not believe its checkpoint.
//! - Times are policy time. After missed decisions `resumed` restarts them, or every motion
//!   would be late at once.
//!
//! A change must keep the view free of state: everything that is remembered is in [`Job`],
//! [`ArmMemory`] or the progress of a skill, which are in the checkpoint.

mod drive;
mod seen;
mod surroundings;
mod told;

use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_task::job::Job;
use robocell_task::{Observation, Output, PolicyTime};
use serde::{Deserialize, Serialize};

use crate::refusal::{Refusal, ZoneWait};
use crate::setup::{ArmSetup, ObjectSetup, Setup, Tool};

pub use drive::Drive;

/// A controller without a status for longer than this does not work (ticks of 1 ms).
const ECHO_LIMIT_TICKS: u64 = 100;

/// The memory of one arm, in a policy of several: a [`Job`] has that of one arm only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArmMemory {
    /// Key of the newest goal.
    pub newest_key: u64,
    /// Object in the gripper.
    pub held: Option<usize>,
}

impl ArmMemory {
    /// Whether it can belong to a cell with this number of objects.
    pub(crate) fn is_sound(&self, objects: usize) -> bool {
        self.newest_key < u64::MAX / 2 && self.held.is_none_or(|held| held < objects)
    }
}

/// The commands to an arm so far in one decision, for a view that is created again within the
/// decision.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    acted: bool,
    gripper: GripperGoal,
    open_width_m: f64,
}

/// The view of one arm in one decision.
pub struct World<'w> {
    /// The cell.
    pub setup: &'w Setup,
    /// The observation.
    pub observation: &'w Observation<'w>,
    /// The memory and the counters of the job.
    pub job: &'w mut Job,
    /// Output for goals and the log.
    pub out: &'w mut Output,
    /// Index of the arm.
    pub arm: usize,
    /// Whether this is the first decision after missed ones, or after the operator led the arm:
    /// skills restart their times.
    pub resumed: bool,
    /// The memory of a policy of several arms. Without it the job counts the goals, and has
    /// what the first arm holds.
    pub memory: Option<&'w mut ArmMemory>,
    /// The commands to the arm so far in this decision.
    pub told: Told,
    /// Why a skill did not start in this decision. A tree, machine or matrix takes it and fails
    /// the job only if its root failed; otherwise [`World::finish`] fails the job.
    pub refusal: Option<Refusal>,
    /// The zone for which the arm waits, after a while.
    pub zone_wait: Option<ZoneWait>,
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
            refusal: None,
            zone_wait: None,
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
        // Compared in ticks of the observation, not by a clock (ADR 0002): a paused cell has no
        // silence.
        let heard = self.observation.echo(self.arm).is_some_and(|echo| {
            self.observation.sample_id().saturating_sub(echo.tick) <= ECHO_LIMIT_TICKS
        });
        let arm = self.observation.arm(self.arm);
        heard && arm.is_some_and(|arm| arm.fault == 0)
    }

    /// The tool of the arm.
    pub fn tool(&self) -> Tool {
        self.arm_setup().map_or(Tool::None, |arm| arm.tool)
    }

    /// Measured TCP, world frame.
    pub fn tcp(&self) -> Option<Pose> {
        self.observation.tcp(self.arm)
    }

    /// Measured position of the TCP (m); the origin for an arm that is not observed.
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
