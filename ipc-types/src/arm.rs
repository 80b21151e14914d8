//! Between a controller and physics: commands in one direction, status in the other.

use crate::header::Header;
use crate::pose::Pose;
use crate::validate::{
    Check, Invalid, MAX_EFFORT, MAX_JOINT_POSITION, MAX_JOINT_VELOCITY, MAX_POSITION_M, Validate,
    code,
};
use crate::wire::wire;
use crate::{MAX_JOINTS, Text};

code! {
    /// Reaction of a process to a lost or broken peer, mildest first. The worst one in force
    /// wins.
    pub enum StopAction {
        /// Normal operation.
        None = 0,
        /// Category-2-style stop: motion ends on a ramp, drives stay on, the
        /// gripper keeps its command.
        Hold = 3,
        /// Category-1-style stop: ramp, then the drives have no power and the brakes hold, by
        /// friction up to the effort limit of each joint.
        Stop1 = 4,
        /// Category-0-style stop: the drives have no power and the brakes hold, at once.
        Stop0 = 5,
    }
}

code! {
    /// Cause of a [`StopAction`].
    pub enum StopCause {
        /// No cause.
        None = 0,
        /// No decision of the task within its age limit.
        DecisionLost = 1,
        /// No command of the controller within its age limit.
        CommandLost = 3,
        /// Measured joints far from the command.
        TrackingError = 5,
        /// The engine had to disable a body of the arm.
        Quarantine = 7,
    }
}

code! {
    /// How the drives of an arm follow its command.
    pub enum DriveMode {
        /// To the joint positions; efforts are a feed-forward.
        Position = 0,
        /// The joint efforts alone; joint positions are those that were measured.
        Effort = 1,
    }
}

code! {
    /// Whether the arm follows a planned path.
    pub enum PlanState {
        /// No: motion policies move the tool towards the goal.
        None = 0,
        /// A plan was requested. Until its answer the arm moves as before.
        Requested = 1,
        /// The arm follows a path.
        Led = 2,
    }
}

code! {
    /// Reason why an arm does not reach its goal.
    pub enum NotReached {
        /// It moves, or has reached the goal.
        None = 0,
        /// No joint positions bring the tool there.
        Unreachable = 1,
        /// A joint would have to exceed its limit.
        JointLimit = 2,
        /// An obstacle or the arm itself is at the goal or on every way found.
        Blocked = 3,
        /// The arm is stretched or folded so that the tool cannot move on.
        Singular = 4,
        /// The motion policies hold each other off.
        LocalMinimum = 5,
        /// The arm touches an obstacle, or itself, at its present position.
        InCollision = 6,
    }
}

impl NotReached {
    /// Stable name, `like_this`; empty for none.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Unreachable => "unreachable",
            Self::JointLimit => "joint_limit",
            Self::Blocked => "blocked",
            Self::Singular => "singular",
            Self::LocalMinimum => "local_minimum",
            Self::InCollision => "in_collision",
        }
    }
}

/// Points of a path in [`ArmStatus::path`].
// Only people look at them; the path is sampled to fit.
pub const PATH_POINTS: usize = 24;

wire! {
    /// Command of the gripper. Owned by the controller: it is part of every command, so silence
    /// of the task never opens a gripper.
    pub struct GripperCommand {
        /// Distance between the fingers, metres.
        pub width: f64,
        /// Force limit per finger, newtons.
        pub force: f64,
        /// Suction: 1 on, 0 off.
        pub suction: u32,
        /// Zero.
        pub reserved: u32,
    }
}

wire! {
    /// Controller to physics, once per cycle: joint setpoints of the drives.
    pub struct ArmCommand {
        /// Header; `tick` is the tick of the state this answers.
        pub header: Header,
        /// Which arm of the cell, by its place in the cell file.
        pub arm: u32,
        /// Valid entries of the joint arrays.
        pub joint_count: u32,
        /// [`DriveMode`].
        pub drive_mode: u32,
        /// Zero.
        pub reserved: u32,
        /// rad or m.
        pub joint_positions: [f64; MAX_JOINTS],
        /// rad/s or m/s.
        pub joint_velocities: [f64; MAX_JOINTS],
        /// rad/s² or m/s².
        pub joint_accelerations: [f64; MAX_JOINTS],
        /// Feed-forward (gravity, Coriolis, inertia), or with [`DriveMode::Effort`] all that the
        /// drives give; N·m or N.
        pub joint_efforts: [f64; MAX_JOINTS],
        /// The gripper.
        pub gripper: GripperCommand,
    }
}

/// Longest name of a failure in [`ClientState`], with the byte that ends it.
pub const FAILURE_BYTES: usize = 64;

wire! {
    /// The client program that commands an arm over the network. Counts are since the start of the
    /// controller.
    pub struct ClientState {
        /// 1 while a client is connected.
        pub connected: u32,
        /// Clients whose connection has ended.
        pub ended: u32,
        /// Motions that ended as their client wanted.
        pub motions: u32,
        /// Motions that ended in another way: by a rule of the robot, because the drives held, or
        /// with their client.
        pub failures: u32,
        /// Name of the last rule or cause; empty where there was none.
        pub failure: Text<FAILURE_BYTES>,
    }
}

wire! {
    /// Controller to all processes, once per cycle: state and progress of its goal.
    pub struct ArmStatus {
        /// Header; `tick` is the tick of the state this was computed from.
        pub header: Header,
        /// Which arm of the cell.
        pub arm: u32,
        /// [`StopAction`] in force.
        pub stop_action: u32,
        /// [`StopCause`] of it.
        pub stop_cause: u32,
        /// 1 when a goal is being followed.
        pub goal_active: u32,
        /// Generation of the task whose goal is latched.
        pub goal_generation: u32,
        /// Selected controller (see [`crate::ArmGoal::selector`]).
        pub selector: u32,
        /// The latched goal.
        pub goal_id: u64,
        /// Tick of the decision that is latched.
        pub decision_tick: u64,
        /// Age of that decision, ticks.
        pub decision_age_ticks: u64,
        /// Distance of the measured TCP from the goal's position, metres.
        pub position_error: f64,
        /// Angle between measured TCP and the goal's orientation, radians.
        pub orientation_error: f64,
        /// Measured gripper width minus the commanded one, metres.
        pub gripper_error: f64,
        /// TCP of the controller's own integrated state, in the world frame.
        pub setpoint: Pose,
        /// The goal's pose, in the world frame.
        pub target: Pose,
        /// Smallest signed distance of a collision sphere from an obstacle,
        /// metres; 1e3 where there is no obstacle.
        pub min_clearance: f64,
        /// Joints whose acceleration was clipped in this cycle, bit per joint.
        pub clipped_joints: u64,
        /// Cycles in which a joint was clipped.
        pub clipped_cycles: u64,
        /// Cycles run.
        pub cycles: u64,
        /// Missed cycles: ticks of which this controller saw no state, so that it ran no cycle.
        pub missed_cycles: u64,
        /// [`PlanState`].
        pub plan_state: u32,
        /// [`NotReached`].
        pub not_reached: u32,
        /// Number of the last plan that was answered; 0: none yet.
        pub answered_plan: u64,
        /// Part of the path already covered, rad and m alike.
        pub path_at: f64,
        /// Length of the path, rad and m alike; 0 where the arm follows none.
        pub path_length: f64,
        /// The tool at evenly spaced points of the path, world frame, metres; valid
        /// where `path_length` is not 0.
        pub path: [[f64; 3]; PATH_POINTS],
        /// The latched gripper command.
        pub gripper: GripperCommand,
        /// Name of the selected controller.
        pub controller: Text<32>,
        /// The client of an arm that a program over the network commands; else zeros.
        pub client: ClientState,
    }
}

impl GripperCommand {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        // No gripper opens by a metre; a wider command is damaged.
        Check::within("gripper.width", &[self.width], 1.0)?;
        Check::within("gripper.force", &[self.force], MAX_EFFORT)
    }
}

impl Validate for ArmCommand {
    fn validate(&self) -> Result<(), Invalid> {
        // The count first: the slices below use it.
        Check::count("joint_count", self.joint_count, MAX_JOINTS)?;
        let n = self.joint_count as usize;
        Check::within(
            "joint_positions",
            &self.joint_positions[..n],
            MAX_JOINT_POSITION,
        )?;
        Check::within(
            "joint_velocities",
            &self.joint_velocities[..n],
            MAX_JOINT_VELOCITY,
        )?;
        // Accelerations have no limit of their own; the watchdog
        // of physics checks those of the robot.
        Check::within(
            "joint_accelerations",
            &self.joint_accelerations[..n],
            MAX_EFFORT,
        )?;
        Check::within("joint_efforts", &self.joint_efforts[..n], MAX_EFFORT)?;
        Check::code(
            "drive_mode",
            self.drive_mode,
            DriveMode::from_code(self.drive_mode).is_some(),
        )?;
        self.gripper.check()
    }
}

impl Validate for ArmStatus {
    fn validate(&self) -> Result<(), Invalid> {
        Check::code(
            "stop_action",
            self.stop_action,
            StopAction::from_code(self.stop_action).is_some(),
        )?;
        Check::code(
            "stop_cause",
            self.stop_cause,
            StopCause::from_code(self.stop_cause).is_some(),
        )?;
        Check::code(
            "plan_state",
            self.plan_state,
            PlanState::from_code(self.plan_state).is_some(),
        )?;
        Check::code(
            "not_reached",
            self.not_reached,
            NotReached::from_code(self.not_reached).is_some(),
        )?;
        // Summed over joints, so larger than any single one.
        Check::within("path_at", &[self.path_at, self.path_length], 1.0e4)?;
        for point in &self.path {
            Check::within("path", point, MAX_POSITION_M)?;
        }
        let scalars = [
            self.position_error,
            self.orientation_error,
            self.gripper_error,
            self.min_clearance,
        ];
        Check::within("errors", &scalars, 1.0e4)?;
        self.setpoint.check()?;
        self.target.check()?;
        self.gripper.check()?;
        self.client.failure.check("client.failure")?;
        self.controller.check("controller")
    }
}
