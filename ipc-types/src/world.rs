//! The state of the world, as physics publishes it.

use crate::equipment::EquipmentState;
use crate::header::Header;
use crate::panel::OperatorPanel;
pub use crate::panel::PauseCause;
use crate::pose::{Pose, Twist};
use crate::validate::{
    Check, Invalid, MAX_EFFORT, MAX_JOINT_POSITION, MAX_JOINT_VELOCITY, Validate,
};
use crate::wire::wire;
use crate::{MAX_ARMS, MAX_JOINTS, MAX_OBJECTS};

/// [`WorldState::flags`]: the simulation is paused; the same tick is published repeatedly, and
/// ages do not grow.
pub const FLAG_PAUSED: u32 = 1;
/// [`WorldState::flags`]: lockstep; physics waits for every process.
pub const FLAG_LOCKSTEP: u32 = 2;
/// [`WorldState::flags`]: the run ends, all processes may exit.
pub const FLAG_ENDING: u32 = 4;

/// [`ObjectState::flags`]: present in the simulation.
pub const OBJECT_ENABLED: u32 = 1;
/// [`ObjectState::flags`]: touched by a robot or its tool in this tick.
pub const OBJECT_TOUCHED: u32 = 2;
/// [`ObjectState::flags`]: pulled by the operator.
pub const OBJECT_DRAGGED: u32 = 4;
/// [`ObjectState::flags`]: at rest and asleep.
pub const OBJECT_ASLEEP: u32 = 8;
/// [`ObjectState::flags`]: controllers may keep away from it.
pub const OBJECT_OBSTACLE: u32 = 16;

wire! {
    /// The gripper as measured.
    pub struct GripperState {
        /// Distance between the fingers, metres.
        pub width: f64,
        /// Its rate, m/s.
        pub width_velocity: f64,
        /// Contact force between fingers and what they hold, newtons, the
        /// smaller of the two sides.
        pub grip_force: f64,
        /// Suction: fraction of the break limit in use, 0 to 1, the larger of
        /// force and torque.
        pub load: f64,
        /// Suction: force on the cup, mean of the last 16.7 ms, newtons.
        pub suction_force: f64,
        /// Suction: torque about the cup, mean of the last 16.7 ms, N·m.
        pub suction_torque: f64,
        /// Suction: largest force of one tick since it was attached, newtons.
        pub peak_force: f64,
        /// Suction: largest torque of one tick since it was attached, N·m.
        pub peak_torque: f64,
        /// Suction: 1 when something is attached.
        pub attached: u32,
        /// Index of the object held (in contact with both fingers, or
        /// attached) plus 1; 0 for none.
        pub held_object: u32,
        /// Index of the object in the light barrier between the fingers plus 1;
        /// 0 for none.
        pub beam_object: u32,
        /// Suction: 1 while it is switched on.
        pub suction: u32,
        /// Suction: counts switchings-on that attached nothing.
        pub refusals: u32,
        /// [`crate::equipment::SuctionRefusal`] of the last of them.
        pub refusal: u32,
        /// Suction: counts grips that broke.
        pub breaks: u32,
        /// [`crate::equipment::BreakLimit`] of the last of them.
        pub break_limit: u32,
        /// [`crate::equipment::BreakCause`] of the last of them.
        pub break_cause: u32,
        /// Zero.
        pub reserved: u32,
    }
}

wire! {
    /// An arm as measured.
    pub struct ArmState {
        /// Valid entries of the joint arrays.
        pub joint_count: u32,
        /// [`crate::arm::StopAction`] physics' own watchdog has in force.
        pub stop_action: u32,
        /// rad or m.
        pub joint_positions: [f64; MAX_JOINTS],
        /// rad/s or m/s.
        pub joint_velocities: [f64; MAX_JOINTS],
        /// Drive efforts, N·m or N.
        pub joint_efforts: [f64; MAX_JOINTS],
        /// Setpoint of the drives in this tick: the accepted command or physics' own brake
        /// ramp. A new controller starts from it without a bump (ADR 0007). rad or m.
        pub setpoint_positions: [f64; MAX_JOINTS],
        /// rad/s or m/s.
        pub setpoint_velocities: [f64; MAX_JOINTS],
        /// rad/s² or m/s².
        pub setpoint_accelerations: [f64; MAX_JOINTS],
        /// TCP in the world frame.
        pub tcp: Pose,
        /// The gripper.
        pub gripper: GripperState,
        /// Sequence number of the command applied in this tick.
        pub command_seq: u64,
        /// Tick that command answers.
        pub command_tick: u64,
        /// Generation of its writer.
        pub command_generation: u32,
        /// 1 when `fault` is latched until a reset.
        pub fault: u32,
        /// Accepted commands that broke a velocity, acceleration or jerk limit,
        /// and measured positions outside the joint limits, per joint and tick.
        pub limit_violations: u64,
        /// Times the arm, its base aside, started to touch an obstacle, another arm, or, with
        /// other parts than its hand, an object that is an obstacle.
        // Starts, not ticks of contact: a long contact is one event.
        pub obstacle_contacts: u64,
        /// Times two parts of the arm that may not touch started to overlap, by its
        /// self-collision spheres.
        pub self_contacts: u64,
    }
}

wire! {
    /// One movable object; its index in [`WorldState::objects`] is its index in
    /// the cell file.
    pub struct ObjectState {
        /// `OBJECT_*` bits.
        pub flags: u32,
        /// Zero.
        pub reserved: u32,
        /// In the world frame.
        pub pose: Pose,
        /// In the world frame.
        pub twist: Twist,
    }
}

wire! {
    /// Physics to all processes, at the end of every tick.
    pub struct WorldState {
        /// Header; `tick` is the tick this state ends.
        pub header: Header,
        /// `FLAG_*` bits.
        pub flags: u32,
        /// Valid entries of `arms`.
        pub arm_count: u32,
        /// Valid entries of `objects`.
        pub object_count: u32,
        /// Script line physics waits with (lockstep) or passed (real time) and
        /// the launcher has to act on, as its number from 1 up; 0 for none.
        pub script_line: u32,
        /// Script lines that have not fired yet.
        pub script_left: u32,
        /// Bodies the engine had to disable (non-finite), since the start.
        pub quarantined: u32,
        /// Ticks physics started late, since the start (real time only).
        pub overruns: u64,
        /// First tick of this start of physics: that of the state its predecessor saved, or 0
        /// with a fresh scene.
        pub resumed_tick: u64,
        /// Tick of the newest state that is saved for a successor of physics or being written
        /// now; a task keeps its checkpoint as of that state.
        pub saving_tick: u64,
        /// Tick of the state from which a successor of physics would resume.
        pub saved_tick: u64,
        /// Hash over bodies, joints and tick: equal for equal runs.
        // Equal hashes are the proof that two runs are equal; it
        // covers no clock and no process id.
        pub state_hash: u64,
        /// Requests of people.
        pub panel: OperatorPanel,
        /// Inputs of the cell's equipment.
        pub equipment: EquipmentState,
        /// Arms, by their place in the cell file.
        pub arms: [ArmState; MAX_ARMS],
        /// Objects, by their place in the cell file.
        pub objects: [ObjectState; MAX_OBJECTS],
    }
}

impl WorldState {
    /// Whether `flag` is set.
    pub fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// Takes over all of `other` but the objects beyond those that it has: a tenth of the bytes in
    /// most cells.
    pub fn copy_from(&mut self, other: &Self) {
        // Without `..`: a new field that is forgotten here would be missing in recordings.
        let Self {
            header,
            flags,
            arm_count,
            object_count,
            script_line,
            script_left,
            quarantined,
            overruns,
            resumed_tick,
            saving_tick,
            saved_tick,
            state_hash,
            panel,
            equipment,
            arms,
            objects: _,
        } = other;
        (self.header, self.panel, self.equipment) = (*header, *panel, *equipment);
        (self.flags, self.arms) = (*flags, *arms);
        (self.arm_count, self.object_count) = (*arm_count, *object_count);
        (self.script_line, self.script_left) = (*script_line, *script_left);
        (self.quarantined, self.overruns) = (*quarantined, *overruns);
        (self.resumed_tick, self.state_hash) = (*resumed_tick, *state_hash);
        (self.saving_tick, self.saved_tick) = (*saving_tick, *saved_tick);
        let objects = other.objects();
        self.objects[..objects.len()].copy_from_slice(objects);
    }

    /// The arms of the cell.
    pub fn arms(&self) -> &[ArmState] {
        // Bounded by the array: the slice must be safe before the message is validated.
        &self.arms[..(self.arm_count as usize).min(MAX_ARMS)]
    }

    /// The objects of the cell.
    pub fn objects(&self) -> &[ObjectState] {
        &self.objects[..(self.object_count as usize).min(MAX_OBJECTS)]
    }
}

impl Validate for ArmState {
    // Used joints only: the rest of the arrays is left from other messages.
    fn validate(&self) -> Result<(), Invalid> {
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
        Check::within("joint_efforts", &self.joint_efforts[..n], MAX_EFFORT)?;
        // Setpoints are checked like measurements: a new controller starts from them.
        Check::within(
            "setpoint_positions",
            &self.setpoint_positions[..n],
            MAX_JOINT_POSITION,
        )?;
        Check::within(
            "setpoint_velocities",
            &self.setpoint_velocities[..n],
            MAX_JOINT_VELOCITY,
        )?;
        Check::within(
            "setpoint_accelerations",
            &self.setpoint_accelerations[..n],
            MAX_EFFORT,
        )?;
        self.tcp.check()?;
        // One limit for all: each is a force, a torque or a width far below it.
        let gripper = &self.gripper;
        let scalars = [
            gripper.width,
            gripper.width_velocity,
            gripper.grip_force,
            gripper.load,
            gripper.suction_force,
            gripper.suction_torque,
            gripper.peak_force,
            gripper.peak_torque,
        ];
        Check::within("gripper", &scalars, MAX_EFFORT)
    }
}

impl Validate for WorldState {
    // Counts first, as the loops below use them; then only used entries: 160 objects would cost
    // the 1 kHz readers time.
    fn validate(&self) -> Result<(), Invalid> {
        Check::count("arm_count", self.arm_count, MAX_ARMS)?;
        Check::count("object_count", self.object_count, MAX_OBJECTS)?;
        for arm in self.arms() {
            arm.validate()?;
        }
        for object in self.objects() {
            object.pose.check()?;
            object.twist.check()?;
        }
        self.panel.check()?;
        self.equipment.validate()
    }
}
