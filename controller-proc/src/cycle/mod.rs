//! The 1 kHz cycle of one arm, as a pure function of its inputs.
//!
//! Three setpoints meet here. A [`Setpoint`] is what a controller has to reach in this cycle. The
//! *setpoint of the drives* (`ArmState::setpoint_positions`) is the newest command that physics
//! accepted. `ArmStatus::setpoint` is the pose of the tool at the command of this cycle.
//!
//! The command of a cycle continues the command of the last one by exactly one millisecond
//! (ADR 0003). The accidents to prevent are a step of the command, and a run that a replay or
//! a successor cannot repeat:
//!
//! - A controller starts from the setpoint of the drives, which physics publishes, never from
//!   the measured state (ADR 0007). It does so again at each state in which physics holds the
//!   arm.
//! - Nothing here reads a clock: ages are differences of ticks (ADR 0002).
//! - Each value that the next cycle depends on is in the checkpoint. A new field without its
//!   line in `Cycle::checkpoint` makes a verified replay differ, and needs a new
//!   [`VERSION`](crate::checkpoint::VERSION).
//! - A cycle does not allocate or wait. Planning takes up to some 100 ms, so it is only
//!   requested here (ADR 0021).
//! - A stop brakes within the limits and keeps the gripper; after a tracking error the arm moves to
//!   its measured joints. At rest it continues to evade obstacles.

use cell_model::stop::{ControllerFlags, Stop, controller_stop};
use cell_model::{Cell, Dynamics};
use ipc_types::arm::{StopAction, StopCause};
use ipc_types::decision::GoalKind;
use ipc_types::{ArmCommand, ArmGoal, ArmState, ArmStatus, Decision, MAX_JOINTS, WorldState};
use nalgebra::{Isometry3, Vector3};

use crate::arm_motion::ArmMotion;
use crate::controller::{CombinedController, Controller, Setpoint};
use crate::controllers::{Controllers, PLANNED, RMPFLOW};
use crate::convert::isometry;
use crate::corridor::Corridor;
use crate::error::RmpFlowError;
use crate::goal::GoalLatch;
use crate::gripper_controller::GripperController;
use crate::planning::PlanGoal;
use crate::robot_state::RobotState;
use crate::suction::SuctionController;

mod checkpoint;
mod output;
mod plans;

pub use plans::PlanAsked;

/// The controller of one arm.
pub struct Cycle {
    arm: usize,
    joint_count: usize,
    base: Isometry3<f64>,
    gripper: Option<cell_model::ParallelGripper>,
    controllers: CombinedController<ArmMotion, GripperController>,
    suction: SuctionController,
    dynamics: Dynamics,
    latch: GoalLatch,
    /// The last command; the tracking error is measured against it.
    last: RobotState,
    /// Generation of physics and count of scene resets of the present motion.
    began_with: Option<(u32, u32)>,
    /// Something blocks the arm: the command returns to its measured position.
    is_giving_way: bool,
    cycles: u64,
    clipped_cycles: u64,
    missed_cycles: u64,
    last_tick: Option<u64>,
}

impl Cycle {
    /// The controller of arm `arm` of `cell`, with the built-in controllers.
    ///
    /// # Errors
    /// [`RmpFlowError`] if the cell has no arm of this number, or the robot's tuning does not
    /// fit the robot.
    pub fn new(cell: &Cell, arm: usize) -> Result<Self, RmpFlowError> {
        Self::with(cell, arm, &Controllers::default())
    }

    /// As [`Cycle::new`], with these controllers beside RMPflow.
    ///
    /// # Errors
    ///
    /// As [`Cycle::new`].
    pub fn with(cell: &Cell, arm: usize, controllers: &Controllers) -> Result<Self, RmpFlowError> {
        let spec = cell.arms.get(arm).ok_or(RmpFlowError::NoSuchArm(arm))?;
        let motion = ArmMotion::new(cell, arm, controllers)?;
        let joint_count = spec.robot.arm_joints.len();
        let fingers = if spec.robot.gripper.is_some() { 2 } else { 0 };
        let open = spec.robot.gripper.as_ref().map_or(0.0, |g| g.max_width);
        let hand = GripperController::new(joint_count, fingers, open);
        Ok(Self {
            arm,
            joint_count,
            base: spec.base,
            gripper: spec.robot.gripper.clone(),
            controllers: CombinedController::new(motion, hand),
            suction: SuctionController::new(spec.robot.suction.is_some()),
            dynamics: Dynamics::new(&spec.robot),
            latch: GoalLatch::default(),
            last: RobotState::EMPTY,
            began_with: None,
            is_giving_way: false,
            cycles: 0,
            clipped_cycles: 0,
            missed_cycles: 0,
            last_tick: None,
        })
    }

    /// One cycle: from the newest state and the newest decision caused by an
    /// earlier tick to the command and the status, which are written in place.
    pub fn update(
        &mut self,
        state: &WorldState,
        decision: Option<&Decision>,
        decision_limit_ticks: u64,
        command: &mut ArmCommand,
        status: &mut ArmStatus,
    ) {
        let Some(arm) = state.arms().get(self.arm) else {
            return;
        };
        // Take the inputs: a new start first, since it resets the motion, which the rest of the
        // cycle then uses.
        let drives = drives(arm, self.joint_count);
        self.start_if_new(state, arm, &drives);
        if let Some(decision) = decision {
            self.latch.take(decision, self.arm);
        }
        // The stop is decided on the last command, before the motion of this cycle.
        let stop = self.stop(state.header.tick, arm, decision_limit_ticks);
        self.is_giving_way = stop.cause == StopCause::TrackingError;
        // Choose the controller of the arm, the bodies that it evades, the hand and suction.
        self.choose(state, stop);
        // Compute: joints and fingers one millisecond later.
        let setpoint = self.setpoint(stop, arm);
        let computed = self.controllers.forward(&drives, &setpoint);
        // Take the result, or the rest of the drives while physics holds the arm. It is within the
        // limits of the joints already.
        self.take_or_repeat(computed.as_ref(), arm, &drives);
        // Write both messages; `ArmLoop::publish` sends them, the status first.
        self.count(state.header.tick);
        self.write_command(state, command);
        self.write_status(state, arm, stop, status);
    }

    /// Generation and number of the decision that is latched.
    pub fn latched(&self) -> Option<(u32, u64)> {
        self.latch.decision_tick()?;
        Some((self.latch.generation(), self.latch.seq()))
    }

    /// Joint positions of the last command (rad or m).
    pub fn joint_positions(&self) -> &[f64] {
        self.last.positions.first(self.joint_count)
    }

    /// Starts from the setpoint of the drives, so without a step: at the first state, when
    /// physics was restarted, when the scene was reset, and in each cycle in which physics holds
    /// the arm.
    fn start_if_new(&mut self, state: &WorldState, arm: &ArmState, drives: &RobotState) {
        let now = (state.header.generation, state.panel.scene_reset);
        let stopped = arm.stop_action >= StopAction::Hold.code();
        if self.began_with == Some(now) && !stopped {
            return;
        }
        // Another start of physics, and a reset, are another scene: neither a goal of the one
        // before applies, nor a decision about it that arrives later.
        if self.began_with != Some(now) {
            self.latch = GoalLatch::since(state.header.tick);
        }
        self.began_with = Some(now);
        self.last = *drives;
        // The ticks up to this state were not missed by this motion.
        self.last_tick = None;
        self.controllers.reset(drives);
        self.controllers.hand.begin(&arm.gripper);
        self.suction.start(&arm.gripper);
    }

    /// Sets what the controllers of this cycle follow: bodies to evade, the goal's selector, and
    /// the hand.
    fn choose(&mut self, state: &WorldState, stop: Stop) {
        let goal = self.latch.goal();
        let motion = &mut self.controllers.arm;
        // Also while the arm holds: it still evades, and must see the other arm move.
        motion.observe(state, self.arm, goal.object_mask);
        // Another controller may follow no joints, and would press on against what blocks the arm.
        let gives_way = self.is_giving_way && stop.stops_motion();
        let is_rmpflow = matches!(goal.selector, RMPFLOW | PLANNED);
        motion.select(if gives_way && !is_rmpflow {
            RMPFLOW
        } else {
            goal.selector
        });
        let hand = &mut self.controllers.hand;
        hand.follow(self.latch.gripper(), self.latch.goal().open_width);
        self.suction.follow(self.latch.gripper());
    }

    /// Takes the computed command, or repeats the last one if there is none. The limits of the
    /// joints are kept where the joints are computed, since a command that is cut afterwards
    /// would step: RMPflow resolves within them, and behind each other controller is a
    /// [`Follower`](crate::follower::Follower).
    ///
    /// While physics holds an arm at rest, the command is that rest. Physics accepts any of
    /// these commands, however late it arrives, because each of them continues from the same
    /// setpoint (ADR 0014).
    fn take_or_repeat(
        &mut self,
        computed: Option<&RobotState>,
        arm: &ArmState,
        drives: &RobotState,
    ) {
        if let Some(computed) = computed {
            self.last = *computed;
        }
        let n = self.joint_count;
        let (rates, changes) = (drives.velocities.first(n), drives.accelerations.first(n));
        // During the brake ramp the setpoint still moves; the command follows the motion
        // instead.
        let moves = rates.iter().chain(changes).any(|value| *value != 0.0);
        if arm.stop_action < StopAction::Hold.code() || moves {
            return;
        }
        let last = &mut self.last;
        last.positions.set_from(0, drives.positions.first(n));
        last.velocities.set_from(0, rates);
        last.accelerations.set_from(0, changes);
        // The integrated state is put back as well, so that the next cycle continues from the
        // same place.
        self.controllers.arm.reset(drives);
    }

    fn stop(&self, tick: u64, arm: &ArmState, decision_limit_ticks: u64) -> Stop {
        // The largest joint, not a norm: one blocked joint must not be hidden by the others.
        let commanded = self.last.positions.first(self.joint_count);
        let tracking_error = commanded
            .iter()
            .zip(&arm.joint_positions)
            .fold(0.0_f64, |worst, (c, m)| worst.max((c - m).abs()));
        controller_stop(&ControllerFlags {
            decision_age_ticks: self.latch.decision_tick().map(|d| tick.saturating_sub(d)),
            decision_limit_ticks,
            tracking_error,
            is_giving_way: self.is_giving_way,
            fault: arm.fault != 0,
        })
    }

    fn setpoint(&self, stop: Stop, arm: &ArmState) -> Setpoint {
        let goal = self.latch.goal();
        let kind = match stop.stops_motion() {
            // Holding the command would press against the obstacle for as long as it is there.
            true if self.is_giving_way => GoalKind::Joints,
            true => GoalKind::Hold,
            false => self.latch.kind(),
        };
        let mut setpoint = Setpoint {
            obstacle_mask: goal.obstacle_mask,
            ..Setpoint::EMPTY
        };
        // At the measured joints the drives press against nothing.
        let posture = if self.is_giving_way {
            Some(&arm.joint_positions)
        } else {
            (goal.has_posture != 0 || kind == GoalKind::Joints).then_some(&goal.posture)
        };
        if let Some(posture) = posture {
            let posture = &posture[..self.joint_count.min(MAX_JOINTS)];
            setpoint.joints.positions.set_from(0, posture);
        }
        match kind {
            GoalKind::Hold => setpoint.hold = true,
            GoalKind::Joints => {}
            GoalKind::Pose => {
                let target = self.base.inverse() * isometry(&goal.target);
                // Goals are in the world frame, policies in the frame of the base.
                setpoint.goal = Some(PlanGoal {
                    pose: target,
                    approach: self.base.rotation.inverse() * Vector3::from(goal.approach),
                    by_joints: false,
                });
                setpoint.position = Some(self.approach(goal, &target));
                setpoint.orientation = Some(target.rotation);
            }
        }
        setpoint
    }

    /// The target's position, shifted back into the approach corridor.
    fn approach(&self, goal: &ArmGoal, target: &Isometry3<f64>) -> Vector3<f64> {
        let corridor = Corridor {
            direction: self.base.rotation.inverse() * Vector3::from(goal.approach),
            std_dev: goal.approach_std_dev,
        };
        let tool = self.controllers.arm.tool_pose();
        let wanted = (target.translation.vector, Some(target.rotation));
        corridor.shift(wanted, (tool.translation.vector, tool.rotation))
    }

    fn count(&mut self, tick: u64) {
        self.cycles += 1;
        // The tick of this cycle itself is not missed.
        if let Some(last) = self.last_tick {
            self.missed_cycles += tick.saturating_sub(last).saturating_sub(1);
        }
        self.last_tick = Some(tick);
        let clipped = self.controllers.arm.clipped_joints();
        self.clipped_cycles += u64::from(clipped != 0);
    }
}

/// The setpoint of the drives.
fn drives(arm: &ArmState, joint_count: usize) -> RobotState {
    let n = joint_count.min(MAX_JOINTS);
    let mut state = RobotState::EMPTY;
    state.positions.set_from(0, &arm.setpoint_positions[..n]);
    state.velocities.set_from(0, &arm.setpoint_velocities[..n]);
    state
        .accelerations
        .set_from(0, &arm.setpoint_accelerations[..n]);
    state
}
