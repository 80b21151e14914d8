//! The interface that authors of tasks implement, and the form in which a task stores it.

use behavior::{Graph, NodeStatus};
use cell_model::Cell;
use cell_model::cells::replace::Replace;
use cell_model::runs::policy_server::ServerReport;
use ipc_types::{Pose, Text};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::checkpoint;
use crate::job::Job;
use crate::observation::Observation;
use crate::output::Output;
use crate::ring;

/// A decision maker in plain code.
///
/// Its decisions depend on the observation and on its [`Policy::Memory`],
/// and on nothing else: no clock, no random number, no file. Then a run is the
/// same in one process and in four, it can be computed again, and a new process
/// resumes where the old one was killed.
pub trait Policy: Send {
    /// All it remembers from one decision to the next. It is in the checkpoint
    /// of every decision; `Memory::default()` is the memory before the
    /// first one.
    type Memory: Default + Serialize + DeserializeOwned + Send;

    /// One decision, every [`ipc_types::DECISION_TICKS`] ticks. `out` is empty at the call:
    /// an arm without an intent holds and keeps its gripper.
    fn decide(
        &self,
        memory: &mut Self::Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    );

    /// Whether a memory from a checkpoint can be used; otherwise the policy starts from its
    /// default memory. A policy that stores indices of the cell's objects has to check them.
    fn is_sound(&self, _memory: &Self::Memory) -> bool {
        true
    }

    /// Name of the phase it is in, for people and scripts; at most 32 bytes.
    #[allow(
        clippy::unnecessary_literal_bound,
        reason = "a policy may compute its names"
    )]
    fn phase(&self, _memory: &Self::Memory) -> &str {
        ""
    }

    /// Names of its phases in the order in which they follow each other; the
    /// picture of the policy is a ring of them.
    fn phases(&self) -> &[&str] {
        &[]
    }

    /// Its picture.
    fn describe(&self, name: &str) -> Graph {
        ring::graph(name, self.phases())
    }

    /// Appends the status of each node of [`Policy::describe`].
    fn statuses(&self, memory: &Self::Memory, out: &mut Vec<NodeStatus>) {
        ring::statuses(self.phases(), self.phase(memory), out);
    }

    /// Compares the memory with the observation: after missed decisions, after the operator
    /// moved the arm, at a start with an object in the gripper, and when this policy
    /// continues a `job` of another one. The default implementation resets the memory when
    /// the job and the gripper of the first arm disagree about the held object.
    fn reconcile(
        &self,
        memory: &mut Self::Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        _out: &mut Output,
    ) {
        let held = observation.held_object(0);
        // The measurement wins: a policy that believes in an object that it does not hold would
        // carry nothing to the goal, and one that ignores a held one would close on it again.
        if job.held != held {
            *memory = Self::Memory::default();
            job.held = held;
        }
    }

    /// Controls the cell's equipment while the operator moves the arm and after
    /// the job failed: a belt has to stop where a bin waits.
    fn tend(&self, _observation: &Observation<'_>, _job: &mut Job) {}

    /// Whether the operator's targets are its job: then a pause does not take
    /// the arm from it.
    fn follows_operator(&self) -> bool {
        false
    }
}

/// A policy of any kind, as a task stores it: plain code with its memory, or an engine
/// with a tree, a machine or a matrix.
pub trait AnyPolicy: Send {
    /// Resets it to the state before the first decision.
    fn reset(&mut self);

    /// Probable mistakes in its files, found when it is made for `cell`: lines for people.
    fn warnings(&self, _cell: &Cell) -> Vec<String> {
        Vec::new()
    }

    /// Replaces leaves of its trees by fixed results; before the first decision.
    ///
    /// # Errors
    /// Why a rule cannot apply: it names no leaf, or the policy has no tree.
    fn replace(&mut self, _rules: &[Replace]) -> Result<(), String> {
        Err("it is not a tree, and only leaves of trees are replaced".to_owned())
    }

    /// One decision; see [`Policy::decide`].
    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output);

    /// See [`Policy::tend`].
    fn tend(&self, _observation: &Observation<'_>, _job: &mut Job) {}

    /// Name of the phase it is in, empty between transfers.
    fn phase(&self) -> Text<32>;

    /// Its pictures: one per tree, machine or arm, always in this order. `name`
    /// is the name of the policy.
    fn describe(&self, name: &str) -> Vec<Graph>;

    /// Appends the status of each node of picture `graph`.
    fn statuses(&self, graph: usize, out: &mut Vec<NodeStatus>);

    /// Its part of the checkpoint; see [`AnyPolicy::restore`].
    fn save(&self) -> Vec<u8>;

    /// Restores what [`AnyPolicy::save`] returned.
    ///
    /// # Errors
    /// When `bytes` do not belong to this policy; it is then as after a reset.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error>;

    /// Whether [`AnyPolicy::restore`] restored the memory, or there was none to restore:
    /// the checkpoint of a policy in Python may have lost all of it.
    fn has_resumed(&self) -> bool {
        true
    }

    /// See [`Policy::follows_operator`].
    fn follows_operator(&self) -> bool {
        false
    }

    /// Pose of the TCP of `arm` to which a reset of the task returns it, world frame; `None`
    /// for its joints at the start of the run.
    fn default_pose(&self, _arm: usize) -> Option<Pose> {
        None
    }

    /// See [`Policy::reconcile`].
    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output);

    /// What the server of a policy behind a socket was asked so far; `None` without one.
    fn server_report(&self) -> Option<ServerReport> {
        None
    }

    /// Warnings since the last call that do not depend on the decisions.
    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// A policy in plain code together with its memory.
struct Stateful<P: Policy> {
    policy: P,
    memory: P::Memory,
}

/// A policy in plain code in the form that a task stores.
pub fn boxed<P: Policy + 'static>(policy: P) -> Box<dyn AnyPolicy> {
    Box::new(Stateful {
        policy,
        memory: P::Memory::default(),
    })
}

impl<P: Policy> AnyPolicy for Stateful<P> {
    fn reset(&mut self) {
        self.memory = P::Memory::default();
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        self.policy.decide(&mut self.memory, observation, job, out);
        // A policy that set its own name of the phase keeps it.
        if out.phase == Text::EMPTY {
            out.phase = self.phase();
        }
    }

    fn tend(&self, observation: &Observation<'_>, job: &mut Job) {
        self.policy.tend(observation, job);
    }

    fn phase(&self) -> Text<32> {
        Text::new(self.policy.phase(&self.memory))
    }

    fn describe(&self, name: &str) -> Vec<Graph> {
        vec![self.policy.describe(name)]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        self.policy.statuses(&self.memory, out);
    }

    fn save(&self) -> Vec<u8> {
        checkpoint::to_bytes(&self.memory)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        // Bytes of another build with the same name may not decode. The reset keeps a half
        // decoded memory from being used.
        let memory = checkpoint::from_bytes(bytes).inspect_err(|_| self.reset())?;
        if self.policy.is_sound(&memory) {
            self.memory = memory;
        } else {
            self.reset();
        }
        Ok(())
    }

    fn follows_operator(&self) -> bool {
        self.policy.follows_operator()
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        self.policy
            .reconcile(&mut self.memory, observation, job, out);
    }
}
