//! The policy of a cell that a program drives: it gives arms and equipment the commands from
//! between two calls of `Cell.step`.

use std::sync::Arc;

use behavior::NodeStatus;
use behavior::graph::Graph;
use ipc_types::Text;
use ipc_types::trace::TraceEvent;
use robocell_skills::ArmMemory;
use robocell_task::{AnyPolicy, Job, Observation, Output, checkpoint};
use serde::{Deserialize, Serialize};

use crate::command::Command;
use crate::inner::{Asked, Inner, Shared, lock};

/// Name of the policy.
pub(crate) const NAME: &str = "outside";

/// Its memory between two decisions.
#[derive(Serialize, Deserialize)]
pub(crate) struct Memory {
    kept: Vec<Option<Command>>,
    arms: Vec<ArmMemory>,
    asked: Asked,
}

impl Memory {
    /// That of `inner`.
    pub(crate) fn of(inner: &Inner) -> Self {
        Self {
            kept: inner.kept().to_vec(),
            arms: inner.decision.memories.clone(),
            asked: inner.asked,
        }
    }

    /// Gives it back to `inner`.
    pub(crate) fn put(self, inner: &mut Inner) {
        inner.keep(self.kept);
        if self.arms.len() == inner.decision.memories.len() {
            inner.decision.memories = self.arms;
        }
        inner.asked = self.asked;
    }
}

/// Gives the commands from outside of decisions.
pub(crate) struct Outside {
    shared: Shared,
}

impl Outside {
    pub(crate) fn new(shared: &Shared) -> Self {
        Self {
            shared: Arc::clone(shared),
        }
    }
}

impl AnyPolicy for Outside {
    fn reset(&mut self) {
        let mut inner = lock(&self.shared);
        inner.decision.memories.fill(ArmMemory::default());
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let mut inner = lock(&self.shared);
        inner.decision.begin(observation, job, out);
        let given = inner.give_kept();
        // Before the event below: until `end` the output of this decision is in `inner`.
        inner.decision.end(true, job, out);
        if let Err(problem) = given {
            out.event(TraceEvent::Fault, format_args!("[fault] {problem}"));
        }
    }

    fn phase(&self) -> Text<32> {
        Text::EMPTY
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        Vec::new()
    }

    fn statuses(&self, _graph: usize, _out: &mut Vec<NodeStatus>) {}

    fn save(&self) -> Vec<u8> {
        checkpoint::to_bytes(&Memory::of(&lock(&self.shared)))
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let memory: Memory = checkpoint::from_bytes(bytes)?;
        memory.put(&mut lock(&self.shared));
        Ok(())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        self.decide(observation, job, out);
    }
}
