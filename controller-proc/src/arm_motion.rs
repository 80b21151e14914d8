//! The motion of an arm: by RMPflow, or by the controller that the goal selects.

use cell_model::Cell;
use ipc_types::WorldState;
use nalgebra::Isometry3;

use crate::checkpoint::{CheckpointError, Codec};
use crate::controller::{Controller, SelectableController, SequentialController, Setpoint};
use crate::controllers::{Controllers, PLANNED, RMPFLOW};
use crate::error::RmpFlowError;
use crate::follower::Follower;
use crate::planning::{PlanAnswer, PlanReport, PlanRequest};
use crate::rmpflow_controller::RmpFlowController;
use crate::robot_state::RobotState;

/// A controller beside RMPflow, with the follower that keeps the limits.
type Followed = SequentialController<Box<dyn Controller>, Follower>;

/// All controllers of one arm. A switch takes effect at the next forward; the new controller
/// starts from the last command, so the arm does not jump. RMPflow executes every hold, with
/// any selector.
pub struct ArmMotion {
    controllers: SelectableController<u32, RmpFlowController, Followed>,
    selector: u32,
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
        let made = controllers.make(cell, arm)?.into_iter();
        let controllers = made.fold(
            SelectableController::new(rmpflow),
            |all, (selector, name, controller)| {
                let follower = Follower::new(&spec.robot);
                all.or(
                    selector,
                    name,
                    SequentialController::new(controller, follower),
                )
            },
        );
        Ok(Self {
            controllers,
            selector: RMPFLOW,
            tool_pose: Isometry3::identity(),
        })
    }

    /// Selects a controller for the next forward; `false` if no controller has that number.
    /// The arm then holds.
    pub fn select(&mut self, selector: u32) -> bool {
        self.selector = selector;
        let rmpflow = self.controllers.default_mut();
        rmpflow.follow_paths(selector == PLANNED);
        self.is_known()
    }

    fn is_known(&self) -> bool {
        matches!(self.selector, RMPFLOW | PLANNED) || self.controllers.has(&self.selector)
    }

    /// Name of the controller that gave the last command; `None` for RMPflow.
    pub fn active_name(&self) -> Option<&'static str> {
        self.controllers.active().map(|(name, _)| name)
    }

    /// See [`RmpFlowController::see`].
    pub fn see(&mut self, state: &WorldState, arm: usize, object_mask: u64) {
        self.controllers.default_mut().see(state, arm, object_mask);
    }

    /// See [`Planning::request`](crate::planning).
    pub(crate) fn plan_request(&self) -> Option<&PlanRequest> {
        self.controllers.default().planning().request()
    }

    pub(crate) fn empty_plan_request(&self) -> PlanRequest {
        self.controllers.default().planning().empty_request()
    }

    pub(crate) fn answer_plan(&mut self, slot: &mut Option<PlanAnswer>) {
        self.controllers.default_mut().planning_mut().answer(slot);
    }

    pub(crate) fn plan_report(&self) -> PlanReport {
        self.controllers.default().planning().report()
    }

    /// TCP of the last command in the base frame.
    pub fn tool_pose(&self) -> Isometry3<f64> {
        match self.controllers.active() {
            None => self.controllers.default().tool_pose(),
            Some(_) => self.tool_pose,
        }
    }

    /// Smallest distance of a sphere from an obstacle in the last cycle of RMPflow
    /// (m).
    pub fn min_clearance(&self) -> f64 {
        self.controllers.default().min_clearance()
    }

    /// Joints held back by a limit in the last cycle, bit per joint.
    pub fn clipped_joints(&self) -> u64 {
        match self.controllers.active() {
            None => self.controllers.default().clipped_joints(),
            Some((_, followed)) => followed.second().clipped_joints(),
        }
    }

    /// Writes or reads the state from cycle to cycle.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        self.controllers.default_mut().checkpoint(codec)?;
        codec.u32(&mut self.selector)?;
        codec.pose(&mut self.tool_pose)?;
        self.controllers.checkpoint(codec, |followed, codec| {
            let (controller, follower) = followed.parts_mut();
            codec.f64s(controller.memory())?;
            follower.checkpoint(codec)
        })
    }
}

impl Controller for ArmMotion {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        self.controllers.reset(estimated)
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        let selected = (!setpoint.hold).then_some(&self.selector);
        self.controllers.select(selected);
        let setpoint = Setpoint {
            // An unknown number holds the arm: any controller that exists would be a guess.
            hold: setpoint.hold || !self.is_known(),
            ..*setpoint
        };
        let command = self.controllers.forward(estimated, &setpoint)?;
        // Clearance and path are reported for the pose of the command in force.
        if self.controllers.active().is_some() {
            self.tool_pose = self.controllers.default_mut().tool_pose_at(&command);
        }
        Some(command)
    }
}
