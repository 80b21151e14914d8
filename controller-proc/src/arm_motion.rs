//! The motion of an arm: by RMPflow, or by the controller that the goal selects.

use cell_model::Cell;
use ipc_types::WorldState;
use nalgebra::Isometry3;

use crate::checkpoint::{CheckpointError, Codec};
use crate::controller::{Controller, SequentialController, Setpoint};
use crate::controllers::{Controllers, PLANNED, RMPFLOW};
use crate::error::RmpFlowError;
use crate::follower::Follower;
use crate::planning::{PlanAnswer, PlanReport, PlanRequest};
use crate::rmpflow_controller::RmpFlowController;
use crate::robot_state::RobotState;

/// A controller beside RMPflow, with the follower that keeps the limits.
struct Choice {
    selector: u32,
    name: &'static str,
    controller: SequentialController<Box<dyn Controller>, Follower>,
}

/// All controllers of one arm. A switch takes effect at the next forward; the new controller
/// starts from the last command, so the arm does not jump. RMPflow executes every hold, with
/// any selector.
pub struct ArmMotion {
    rmpflow: RmpFlowController,
    choices: Vec<Choice>,
    /// `None` for RMPflow.
    active: Option<usize>,
    selector: u32,
    last: RobotState,
    /// Tool pose of the last command of another controller.
    tool_pose: Isometry3<f64>,
}

impl ArmMotion {
    /// Those of arm `arm` of `cell`.
    ///
    /// # Errors
    /// [`RmpFlowError`] if the cell has no arm of this number, or the robot's files contradict
    /// each other.
    pub fn new(cell: &Cell, arm: usize, controllers: &Controllers) -> Result<Self, RmpFlowError> {
        let rmpflow = RmpFlowController::new(cell, arm)?;
        let spec = cell.arms.get(arm).ok_or(RmpFlowError::NoSuchArm(arm))?;
        let choice = |(selector, name, controller)| Choice {
            selector,
            name,
            controller: SequentialController::new(controller, Follower::new(&spec.robot)),
        };
        Ok(Self {
            rmpflow,
            choices: controllers
                .make(cell, arm)?
                .into_iter()
                .map(choice)
                .collect(),
            active: None,
            selector: RMPFLOW,
            last: RobotState::EMPTY,
            tool_pose: Isometry3::identity(),
        })
    }

    /// Selects a controller for the next forward; `false` if no controller has that number.
    /// The arm then holds.
    pub fn select(&mut self, selector: u32) -> bool {
        self.selector = selector;
        self.rmpflow.follow_paths(selector == PLANNED);
        self.is_known()
    }

    fn is_known(&self) -> bool {
        matches!(self.selector, RMPFLOW | PLANNED) || self.found().is_some()
    }

    fn found(&self) -> Option<usize> {
        let mut choices = self.choices.iter();
        choices.position(|choice| choice.selector == self.selector)
    }

    /// Name of the controller that gave the last command; `None` for RMPflow.
    pub fn active_name(&self) -> Option<&'static str> {
        let active = self.active.and_then(|active| self.choices.get(active));
        active.map(|choice| choice.name)
    }

    /// See [`RmpFlowController::see`].
    pub fn observe(&mut self, state: &WorldState, arm: usize, object_mask: u64) {
        self.rmpflow.observe(state, arm, object_mask);
    }

    /// See [`Planning::request`](crate::planning).
    pub(crate) fn plan_request(&self) -> Option<&PlanRequest> {
        self.rmpflow.planning().request()
    }

    pub(crate) fn empty_plan_request(&self) -> PlanRequest {
        self.rmpflow.planning().empty_request()
    }

    pub(crate) fn answer_plan(&mut self, slot: &mut Option<PlanAnswer>) {
        self.rmpflow.planning_mut().answer(slot);
    }

    pub(crate) fn plan_report(&self) -> PlanReport {
        self.rmpflow.planning().report()
    }

    /// TCP of the last command in the base frame.
    pub fn tool_pose(&self) -> Isometry3<f64> {
        match self.active {
            None => self.rmpflow.tool_pose(),
            Some(_) => self.tool_pose,
        }
    }

    /// Smallest distance of a sphere from an obstacle in the last cycle of RMPflow
    /// (m).
    pub fn min_clearance(&self) -> f64 {
        self.rmpflow.min_clearance()
    }

    /// Joints held back by a limit in the last cycle, bit per joint.
    pub fn clipped_joints(&self) -> u64 {
        let active = self.active.and_then(|active| self.choices.get(active));
        active.map_or_else(
            || self.rmpflow.clipped_joints(),
            |choice| choice.controller.second().clipped_joints(),
        )
    }

    /// Writes or reads the state from cycle to cycle.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        self.rmpflow.checkpoint(codec)?;
        let mut active = self.active.map_or(0, |active| active + 1);
        codec.index("active controller", &mut active, self.choices.len() + 1)?;
        self.active = active.checked_sub(1);
        codec.u32(&mut self.selector)?;
        self.last.checkpoint(codec)?;
        codec.pose(&mut self.tool_pose)?;
        for choice in &mut self.choices {
            let (first, second) = choice.controller.parts_mut();
            // All of them, not only the active one: the number of values stays the same.
            codec.f64s(first.memory())?;
            second.checkpoint(codec)?;
        }
        Ok(())
    }
}

impl Controller for ArmMotion {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        self.last = *estimated;
        let active = self.active.and_then(|active| self.choices.get_mut(active));
        let others = active.is_none_or(|choice| choice.controller.reset(estimated));
        // RMPflow also while another one is active: it takes over at a hold, in any cycle.
        self.rmpflow.reset(estimated) && others
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        let known = self.is_known();
        let wanted = self.found().filter(|_| !setpoint.hold);
        // From the last command, not from the drives: those are one message behind.
        if wanted != self.active {
            let from = self.last;
            match wanted.and_then(|wanted| self.choices.get_mut(wanted)) {
                Some(choice) => choice.controller.reset(&from),
                None => self.rmpflow.reset(&from),
            };
            self.active = wanted;
        }
        let setpoint = Setpoint {
            // An unknown number holds the arm: any controller that exists would be a guess.
            hold: setpoint.hold || !known,
            ..*setpoint
        };
        let active = self.active.and_then(|active| self.choices.get_mut(active));
        let command = match active {
            Some(choice) => choice.controller.forward(estimated, &setpoint),
            None => self.rmpflow.forward(estimated, &setpoint),
        }?;
        self.last = command;
        // Clearance and path are reported for the pose of the command in force.
        if self.active.is_some() {
            self.tool_pose = self.rmpflow.tool_pose_at(&command);
        }
        Some(command)
    }
}
