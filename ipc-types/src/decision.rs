//! Decisions of the task, for the controllers and for the cell's equipment.

use crate::header::Header;
use crate::pose::Pose;
use crate::validate::{
    Check, Invalid, MAX_EFFORT, MAX_JOINT_POSITION, MAX_POSITION_M, Validate, code,
};
use crate::wire::wire;
use crate::{BreakName, MAX_ARMS, MAX_JOINTS, MAX_OBJECTS, Text};

/// Placed objects a decision can name: all of a cell.
// All of a cell, so that a finished task can name every object.
pub const MAX_PLACED: usize = MAX_OBJECTS;
/// Bytes of the name of a phase.
// Texts are cut with a mark beyond their size: a message has a fixed size and no pointer.
pub const PHASE_BYTES: usize = 32;
/// Bytes of the name of a policy.
pub const POLICY_BYTES: usize = 16;
/// Bytes of the name of a reason.
pub const REASON_BYTES: usize = 64;
/// Bytes of the text about a wait.
pub const WAIT_BYTES: usize = 96;

/// [`ArmGoal::selector`] of RMPflow that planned paths lead around obstacles.
pub const PLANNED: u32 = 3;

code! {
    /// Kind of a goal of an arm.
    pub enum GoalKind {
        /// Stay: motion ends on a ramp. Also the effect of silence.
        Hold = 0,
        /// Bring the TCP to `target`.
        Pose = 1,
        /// Bring the joints to `posture`.
        Joints = 2,
    }
}

code! {
    /// Goal of a gripper.
    pub enum GripperGoal {
        /// Keep the command it has. Also the effect of silence.
        Keep = 0,
        /// Open fully, or let go.
        Open = 1,
        /// Close with the goal's force, or switch suction on.
        Close = 2,
    }
}

code! {
    /// Outcome of a task so far.
    pub enum Outcome {
        /// Waiting for its start event.
        Idle = 0,
        /// At work.
        Running = 1,
        /// Finished as intended.
        Done = 2,
        /// Given up, see `reason`.
        Failed = 3,
        /// Stopped by the operator, keeps its place.
        Paused = 4,
    }
}

wire! {
    /// Goal of one arm. Absolute: sending it again changes nothing.
    pub struct ArmGoal {
        /// Number of the goal, from 1 up; a new number is a new goal. Kept over
        /// a restart of the task.
        pub goal_id: u64,
        /// [`GoalKind`].
        pub kind: u32,
        /// [`GripperGoal`].
        pub gripper: u32,
        /// Controller of the arm: 0 for RMPflow, 1 for joint-space PD, 2 for a Cartesian line,
        /// [`PLANNED`] for RMPflow on planned paths, others as numbered by the controller
        /// program. An unknown one holds the arm.
        pub selector: u32,
        /// 1 when `posture` is given.
        pub has_posture: u32,
        /// TCP in the world frame.
        pub target: Pose,
        /// Joint configuration to prefer, or the goal of [`GoalKind::Joints`]; rad or m.
        pub posture: [f64; MAX_JOINTS],
        /// Force per finger when closing, newtons.
        pub grip_force: f64,
        /// Distance of the fingers when they open, metres; 0 for as far as they open. Kept with
        /// [`GripperGoal::Keep`].
        pub open_width: f64,
        /// Direction of the last part of the approach, scaled by its length in
        /// metres, world frame; zero for a straight attraction.
        pub approach: [f64; 3],
        /// Width of the approach corridor (standard deviation), metres.
        pub approach_std_dev: f64,
        /// Obstacles of the cell file that count, bit per obstacle.
        pub obstacle_mask: u64,
        /// Objects of the cell file that are obstacles and count, bit per such
        /// object.
        pub object_mask: u64,
    }
}

wire! {
    /// Outputs of the task to the cell's equipment, like those of a PLC. Counters increase by
    /// one with every request; a counter that decreased requests nothing.
    pub struct CellIo {
        /// 1 while the belt shall run; silence stops it.
        pub conveyor_running: u32,
        /// Counts requests to drop parts, as many as the dispenser drops at a time.
        pub drop_parts: u32,
        /// Counts requests for a bin.
        pub add_bin: u32,
        /// Zero.
        pub reserved: u32,
    }
}

wire! {
    /// Task to controllers and physics, every [`crate::DECISION_TICKS`] ticks.
    pub struct Decision {
        /// Header; `tick` is the tick of the state this answers.
        pub header: Header,
        /// Valid entries of `goals`.
        pub arm_count: u32,
        /// [`Outcome`].
        pub outcome: u32,
        /// Goals by arm.
        pub goals: [ArmGoal; MAX_ARMS],
        /// Equipment.
        pub io: CellIo,
        /// Name of the phase or state, for people and for scripts.
        pub phase: Text<PHASE_BYTES>,
        /// Name of the policy.
        pub policy: Text<POLICY_BYTES>,
        /// Stable name of the outcome's reason, `like_this`, empty if none.
        pub reason: Text<REASON_BYTES>,
        /// What an arm has been waiting for, for people: `left: zone 'press', which right owns`;
        /// empty if none waits.
        pub wait: Text<WAIT_BYTES>,
        /// Counts entries into a phase, from 1 up.
        pub phase_entry: u32,
        /// Held objects that were lost.
        pub drops: u32,
        /// Pick-ups started again because the object moved.
        pub resyncs: u32,
        /// Transfers turned back because the stack below was gone.
        pub aborts: u32,
        /// Recoveries of any other kind.
        pub recoveries: u32,
        /// Valid entries of `placed`.
        pub placed_count: u32,
        /// Objects at their places, by index in the cell file.
        pub placed: [u32; MAX_PLACED],
        /// Tick at which the task reached a breakpoint last; 0: never. Physics pauses
        /// when it changes.
        pub break_tick: u64,
        /// The breakpoint it reached.
        pub break_name: BreakName,
    }
}

impl Validate for ArmGoal {
    fn validate(&self) -> Result<(), Invalid> {
        Check::code(
            "goal.kind",
            self.kind,
            GoalKind::from_code(self.kind).is_some(),
        )?;
        Check::code(
            "goal.gripper",
            self.gripper,
            GripperGoal::from_code(self.gripper).is_some(),
        )?;
        // Of unused goals nothing is checked: they hold what an earlier message left there.
        self.target.check()?;
        Check::within("goal.posture", &self.posture, MAX_JOINT_POSITION)?;
        Check::within("goal.grip_force", &[self.grip_force], MAX_EFFORT)?;
        Check::within("goal.open_width", &[self.open_width], MAX_POSITION_M)?;
        Check::within("goal.approach", &self.approach, 2.0)?;
        Check::within("goal.approach_std_dev", &[self.approach_std_dev], 2.0)
    }
}

impl Validate for Decision {
    fn validate(&self) -> Result<(), Invalid> {
        // Counts first: the loop below indexes with them.
        Check::count("arm_count", self.arm_count, MAX_ARMS)?;
        Check::count("placed_count", self.placed_count, MAX_PLACED)?;
        Check::code(
            "outcome",
            self.outcome,
            Outcome::from_code(self.outcome).is_some(),
        )?;
        for goal in &self.goals[..self.arm_count as usize] {
            goal.validate()?;
        }
        self.phase.check("phase")?;
        self.policy.check("policy")?;
        self.reason.check("reason")?;
        self.wait.check("wait")?;
        self.break_name.check("break_name")
    }
}
