//! The input of a policy: one coherent sample of the cell.

use ipc_types::arm::{ClientState, NotReached};
use ipc_types::{
    ArmState, ArmStatus, EquipmentState, MAX_ARMS, ObjectState, OperatorPanel, Pose, WorldState,
};
use nalgebra::Vector3;

use crate::time::PolicyTime;

/// What a controller reports about the goal it follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerEcho {
    /// Tick of the state it answered.
    pub tick: u64,
    /// 1-based number of the goal the controller has latched.
    pub goal_id: u64,
    /// Start of the task process whose goal that is. Goal ids are kept over a
    /// restart, so it is for display only.
    pub goal_generation: u32,
    /// Whether the goal is being followed; false while the controller holds.
    pub goal_active: bool,
    /// Distance of the measured TCP from the goal (m).
    pub position_error: f64,
    /// Measured gripper width minus the commanded one (m).
    pub gripper_error: f64,
    /// Why the arm does not get nearer to the goal, if it does not.
    pub not_reached: Option<NotReached>,
    /// The client program of an arm that is commanded over the network.
    pub client: ClientState,
}

impl From<&ArmStatus> for ControllerEcho {
    fn from(status: &ArmStatus) -> Self {
        Self {
            tick: status.header.tick,
            goal_id: status.goal_id,
            goal_generation: status.goal_generation,
            goal_active: status.goal_active == 1,
            position_error: status.position_error,
            gripper_error: status.gripper_error,
            not_reached: NotReached::from_code(status.not_reached)
                .filter(|reason| *reason != NotReached::None),
            client: status.client,
        }
    }
}

/// One immutable sample: the world at one tick, and the newest status of every
/// controller that was sent before it. Poses are in the world frame.
#[derive(Clone, Copy, Debug)]
pub struct Observation<'a> {
    state: &'a WorldState,
    echoes: [Option<ControllerEcho>; MAX_ARMS],
    time: PolicyTime,
}

impl<'a> Observation<'a> {
    /// The sample of `state`; `status` is indexed by arm, `None` where no status of that
    /// controller was received yet.
    pub fn new(state: &'a WorldState, status: &[Option<&ArmStatus>], time: PolicyTime) -> Self {
        let mut echoes = [None; MAX_ARMS];
        for (echo, status) in echoes.iter_mut().zip(status) {
            *echo = status.map(ControllerEcho::from);
        }
        Self {
            state,
            echoes,
            time,
        }
    }

    /// The sample with statuses of controllers that were stored before, by arm: those of
    /// [`Observation::echo`].
    pub fn with_echoes(
        state: &'a WorldState,
        echoes: [Option<ControllerEcho>; MAX_ARMS],
        time: PolicyTime,
    ) -> Self {
        Self {
            state,
            echoes,
            time,
        }
    }

    /// The whole state of the cell.
    pub fn state(&self) -> &'a WorldState {
        self.state
    }

    /// Number of the sample: the tick it shows.
    pub fn sample_id(&self) -> u64 {
        self.state.header.tick
    }

    /// Simulated time minus the time the task was paused.
    pub fn time(&self) -> PolicyTime {
        self.time
    }

    /// An arm as measured.
    pub fn arm(&self, arm: usize) -> Option<&'a ArmState> {
        self.state.arms().get(arm)
    }

    /// The newest status of the controller of `arm`.
    pub fn echo(&self, arm: usize) -> Option<ControllerEcho> {
        self.echoes.get(arm).copied().flatten()
    }

    /// Measured TCP of `arm`.
    pub fn tcp(&self, arm: usize) -> Option<Pose> {
        self.arm(arm).map(|a| a.tcp)
    }

    /// Index of the object the gripper of `arm` holds, as measured.
    pub fn held_object(&self, arm: usize) -> Option<usize> {
        let held = self.arm(arm)?.gripper.held_object;
        // Messages count objects from 1, since a zeroed message has to mean "none".
        (held > 0).then(|| held as usize - 1)
    }

    /// An object by its place in the cell file.
    pub fn object(&self, index: usize) -> Option<&'a ObjectState> {
        self.state.objects().get(index)
    }

    /// Centre of an object (m).
    pub fn object_position(&self, index: usize) -> Option<Vector3<f64>> {
        self.object(index).map(|o| Vector3::from(o.pose.position))
    }

    /// Inputs of the cell's equipment.
    pub fn equipment(&self) -> &'a EquipmentState {
        &self.state.equipment
    }

    /// The requests of the operator.
    pub fn panel(&self) -> &'a OperatorPanel {
        &self.state.panel
    }
}
