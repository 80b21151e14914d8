//! Following the operator: the arm goes where the panel's target is.

use behavior::NodeStatus;
use behavior::graph::{Graph, GraphKind, GraphNode};
use cell_model::task_spec::ReachTask;
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::{GripperGoal, MAX_ARMS, Pose, Text};

use crate::job::Job;
use crate::observation::Observation;
use crate::operator::{operator_target, requested_gripper};
use crate::output::{ArmIntent, Output};
use crate::policy::Policy;
use crate::record;

/// The one phase.
const FOLLOW: &str = "FOLLOW";

/// Follows panel targets and gripper requests always, paused or not. Until the
/// first one it goes to the target of the cell file, or holds without one.
#[derive(Clone, Debug)]
pub struct Follow {
    task: ReachTask,
    grip_force: f64,
    /// TCP orientation at the first decision, for a first target without one.
    first_orientation: Option<[f64; 4]>,
}

impl Follow {
    /// Name on the command line.
    pub const NAME: &'static str = "follow";

    /// `grip_force` is used when the operator closes the gripper (N).
    pub fn new(task: ReachTask, grip_force: f64) -> Self {
        Self {
            task,
            grip_force,
            first_orientation: None,
        }
    }

    fn first_target(&mut self, observation: &Observation<'_>) -> Option<ArmIntent> {
        let position = self.task.position_m?;
        let measured = observation.tcp(0)?.orientation_wxyz;
        let kept = *self.first_orientation.get_or_insert(measured);
        let orientation_wxyz = self.task.orientation_wxyz.unwrap_or(kept);
        let target = Pose {
            position,
            orientation_wxyz,
        };
        Some(ArmIntent {
            kind: GoalKind::Pose,
            target,
            ..ArmIntent::default()
        })
    }
}

impl Policy for Follow {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn reset(&mut self) {
        self.first_orientation = None;
    }

    fn tick(&mut self, observation: &Observation<'_>, _job: &mut Job, out: &mut Output) {
        let panel = observation.panel();
        let given = panel.target_seq > 0;
        // The panel names one arm; the other ones hold.
        let arm = if given {
            (panel.target_arm as usize).min(MAX_ARMS - 1)
        } else {
            0
        };
        let mut intent = if given {
            Some(operator_target(panel))
        } else {
            self.first_target(observation)
        }
        .unwrap_or_default();
        if panel.gripper_seq > 0 {
            intent.gripper = requested_gripper(panel);
            if intent.gripper == GripperGoal::Close {
                intent.grip_force = self.grip_force;
            }
        }
        out.arm(arm, intent);
        out.phase = self.phase();
        out.outcome = Outcome::Running;
    }

    fn phase(&self) -> Text<32> {
        Text::new(FOLLOW)
    }

    fn describe(&self) -> Vec<Graph> {
        vec![Graph {
            kind: GraphKind::Code,
            name: Self::NAME.to_owned(),
            nodes: vec![GraphNode {
                id: FOLLOW.to_owned(),
                kind: "phase".to_owned(),
                name: FOLLOW.to_owned(),
                parent: None,
                detail: "the operator's target".to_owned(),
            }],
            edges: Vec::new(),
        }]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        out.push(NodeStatus::Running);
    }

    fn follows_operator(&self) -> bool {
        true
    }

    fn save(&self) -> Vec<u8> {
        record::to_bytes(&self.first_orientation)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.first_orientation = record::from_bytes(bytes)?;
        Ok(())
    }

    fn reconcile(&mut self, _observation: &Observation<'_>, _job: &mut Job, _out: &mut Output) {}
}
