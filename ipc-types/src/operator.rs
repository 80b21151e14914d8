//! Requests of people and tools, each answered with the tick at which it took effect.

use crate::header::Header;
use crate::pose::Pose;
use crate::validate::{Check, Invalid, MAX_EFFORT, MAX_JOINT_POSITION, Validate, code};
use crate::wire::{Wire, wire};
use crate::{BreakName, GripperGoal, MAX_JOINTS, Text};

/// Contact force at which a target of the operator ends, unless the request has another (N).
// A person who leads an arm presses with a few newtons; a drive that is told to go 1 mm into a table
// presses with more than 300 N.
pub const CONTACT_LIMIT_N: f64 = 30.0;

/// Bytes of the message of a reply.
pub const REPLY_BYTES: usize = 120;

code! {
    /// Action of a request.
    pub enum OperatorAction {
        /// No action: tests whether physics answers.
        Ping = 0,
        /// Stop simulated time.
        Pause = 1,
        /// Let simulated time continue.
        Resume = 2,
        /// Run `count` ticks, then pause.
        Step = 3,
        /// Resets the scene to its start.
        Reset = 4,
        /// Pull `object` to `pose` by a spring for `seconds` at most.
        Drag = 5,
        /// Move the arm: TCP target in the world frame.
        Target = 6,
        /// [`GripperGoal`] in `count`.
        Gripper = 7,
        /// Start event of the task.
        TaskStart = 8,
        /// Pause the task: the operator moves the arm.
        TaskPause = 9,
        /// Let the task continue.
        TaskResume = 10,
        /// Resets the task to its start.
        TaskReset = 11,
        /// Drop `count` parts; 0: as many as the dispenser drops at a time.
        DropParts = 12,
        /// Add a bin; `count` 1: upside down.
        AddBin = 13,
        /// The launcher acted on script line `count`; physics may continue.
        ScriptDone = 14,
        /// End the run: states have [`crate::world::FLAG_ENDING`] from then on.
        End = 15,
        /// Move the arm: joint target in `joints`.
        Joints = 16,
        /// `count` 1: pause when the task reaches the node, state or guard named by
        /// `name`; 0: no longer.
        Break = 17,
        /// Simulated seconds per second, in `seconds`; 0: as fast as possible.
        Speed = 18,
    }
}

code! {
    /// Result of a request.
    pub enum ReplyCode {
        /// Done, or under way.
        Accepted = 0,
        /// The object is not in this cell.
        UnknownObject = 1,
        /// The arm is not in this cell.
        UnknownArm = 2,
        /// A value was out of range.
        OutOfRange = 3,
        /// This cell has no equipment for it.
        NotInThisCell = 4,
    }
}

wire! {
    /// One request.
    pub struct OperatorRequest {
        /// Header.
        pub header: Header,
        /// [`OperatorAction`].
        pub action: u32,
        /// Object by index in the cell file.
        pub object: u32,
        /// Arm by place in the cell file.
        pub arm: u32,
        /// See the action.
        pub count: u32,
        /// See the action; world frame.
        pub pose: Pose,
        /// See the action.
        pub seconds: f64,
        /// Of a target: contact force at which it ends (N); not above 0:
        /// [`CONTACT_LIMIT_N`].
        pub contact_limit: f64,
        /// Joint target, in the order of the controlled joints; rad or m.
        pub joints: [f64; MAX_JOINTS],
        /// See the action.
        pub name: BreakName,
    }
}

wire! {
    /// The answer.
    pub struct OperatorReply {
        /// Header; `tick` is the tick at which the request took effect.
        pub header: Header,
        /// [`ReplyCode`].
        pub code: u32,
        /// Zero.
        pub reserved: u32,
        /// Tick at which a step is done; 0 of other requests.
        pub until_tick: u64,
        /// Text for the person: the reason of a refusal; of an accepted request the condition
        /// that must hold before it takes effect, mostly empty.
        pub message: Text<REPLY_BYTES>,
    }
}

impl OperatorRequest {
    /// A request to fill in: all zeros except for a valid pose.
    pub fn zeroed_at_identity() -> Self {
        Self {
            // All zeros is not a rotation and would be refused.
            pose: Pose::IDENTITY,
            ..Self::zeroed()
        }
    }
}

impl Validate for OperatorRequest {
    fn validate(&self) -> Result<(), Invalid> {
        let action = OperatorAction::from_code(self.action);
        Check::code("action", self.action, action.is_some())?;
        if action == Some(OperatorAction::Gripper) {
            Check::code(
                "gripper",
                self.count,
                GripperGoal::from_code(self.count).is_some(),
            )?;
        }
        // An hour: a drag or a speed beyond it is a mistake in the unit.
        Check::within("seconds", &[self.seconds], 3600.0)?;
        Check::within("contact_limit", &[self.contact_limit], MAX_EFFORT)?;
        Check::within("joints", &self.joints, MAX_JOINT_POSITION)?;
        self.name.check("name")?;
        self.pose.check()
    }
}

impl Validate for OperatorReply {
    fn validate(&self) -> Result<(), Invalid> {
        Check::code("code", self.code, ReplyCode::from_code(self.code).is_some())?;
        self.message.check("message")
    }
}
