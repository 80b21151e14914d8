//! What the stacking policies in plain code have in common: their memory is one
//! transfer, and their picture is the ring of phases with the edges that leave it.

use behavior::Graph;
use robocell_task::{Job, Observation, Output, Policy, ring};

use super::phase::{HOLD, NAMES, Phase};
use super::setup::StackSetup;
use super::transfer::Transfer;
use super::turn::Turn;

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
        memory.map_or(HOLD, |transfer| transfer.phase.name())
    }

    fn phases(&self) -> &[&str] {
        &NAMES
    }

    /// The ring with what leads from one phase to the next, and the edges that leave
    /// it.
    fn describe(&self, name: &str) -> Graph {
        let idle = Phase::RING.len();
        let mut graph = ring::graph(name, &NAMES);
        for (edge, phase) in graph.edges.iter_mut().zip(Phase::RING) {
            let done = match phase {
                Phase::Grasp => "time",
                Phase::Release => "time and gripper open",
                _ => "settled or timeout",
            };
            done.clone_into(&mut edge.label);
        }
        if let Some(chosen) = graph.edges.last_mut() {
            "cube not at its goal".clone_into(&mut chosen.label);
        }
        let drops = Phase::RING.into_iter().filter(|phase| phase.holding());
        let drops = drops.map(|phase| ring::edge(phase as usize, idle, "drop"));
        graph.edges.extend(drops);
        let resync = ring::edge(Phase::Approach as usize, 0, "resync");
        graph.edges.push(resync);
        graph
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
