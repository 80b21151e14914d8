//! The common part of the stacking policies in plain code: their memory is one transfer, and
//! their graph is the ring of phases with the edges that leave it.

use behavior::Graph;
use robocell_task::{Job, Observation, Output, Policy, ring};

use super::phase::{HOLD, NAMES, Phase};
use super::setup::StackSetup;
use super::transfer::Transfer;
use super::turn::Turn;

/// One decision: updates the transfer (`None` between two of them) and commands the arm.
pub type Decide = fn(&mut Option<Transfer>, &mut Turn<'_>);

/// A stacking policy in plain code.
pub struct InCode {
    /// The settings.
    pub setup: StackSetup,
    /// The decision function, in which the policies differ.
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

    /// The ring with the conditions of its edges, and the edges that leave it.
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
