//! What the stacking policies in plain code have in common: their memory is one
//! transfer, and their picture is the ring of phases with the edges that leave it.

use behavior::NodeStatus;
use behavior::graph::{Graph, GraphKind};
use robocell_task::ring::{edge, node, running_if};
use robocell_task::{Job, Observation, Output, Policy};

use super::phase::Phase;
use super::setup::StackSetup;
use super::transfer::Transfer;
use super::turn::{HOLD, Turn};

/// One decision: brings the transfer to where it is after it, `None` between two,
/// and tells the arm what to do.
pub type Decide = fn(&mut Option<Transfer>, &mut Turn<'_>);

/// A stacking policy in plain code.
pub struct InCode {
    /// The numbers.
    pub setup: StackSetup,
    /// What makes one policy another than the next.
    pub decide: Decide,
}

impl Policy for InCode {
    type Memory = Option<Transfer>;

    fn decide(
        &self,
        memory: &mut Option<Transfer>,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        if let Some(mut turn) = Turn::new(&self.setup, observation, job, out) {
            (self.decide)(memory, &mut turn);
            turn.report();
        }
    }

    fn is_sound(&self, memory: &Option<Transfer>) -> bool {
        memory.is_none_or(|transfer| transfer.cube < self.setup.cubes.len())
    }

    fn phase(&self, memory: &Option<Transfer>) -> &str {
        memory.map_or("", |transfer| transfer.phase.name())
    }

    fn describe(&self, name: &str) -> Graph {
        ring(name)
    }

    fn statuses(&self, memory: &Option<Transfer>, out: &mut Vec<NodeStatus>) {
        let active = memory.map(|transfer| transfer.phase);
        out.extend(Phase::RING.map(|phase| running_if(active == Some(phase))));
        out.push(running_if(active.is_none()));
    }

    fn reconcile(
        &self,
        memory: &mut Option<Transfer>,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        if let Some(mut turn) = Turn::new(&self.setup, observation, job, out) {
            Transfer::reconcile(memory, &mut turn);
        }
    }
}

/// The eight phases, and the state in which the next cube is chosen.
fn ring(policy: &str) -> Graph {
    let idle = Phase::RING.len();
    let mut nodes: Vec<_> = Phase::RING.iter().map(|p| node(p.name(), "")).collect();
    nodes.push(node(HOLD, "chooses the next cube"));
    let mut edges = vec![edge(idle, 0, "cube not at its goal")];
    for (from, phase) in Phase::RING.iter().enumerate() {
        let done = match phase {
            Phase::Grasp => "time",
            Phase::Release => "time and gripper open",
            _ => "settled or timeout",
        };
        edges.push(edge(from, phase.next().map_or(idle, |p| p as usize), done));
        if phase.holding() {
            edges.push(edge(from, idle, "drop"));
        }
    }
    edges.push(edge(Phase::Approach as usize, 0, "resync"));
    Graph {
        kind: GraphKind::Code,
        name: policy.to_owned(),
        nodes,
        edges,
    }
}
