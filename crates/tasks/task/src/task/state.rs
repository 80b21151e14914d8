//! The state of a task, saved and restored.

use ipc_types::{Text, WorldState};
use serde::de::Error as _;

use super::Task;
use crate::checkpoint::{self, CheckpointError, TaskCheckpoint, VERSION};
use crate::operator::PanelState;
use crate::time::PolicyClock;

/// What [`Task::restore`] took from a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Restored {
    /// The job and the memory of the policy.
    #[default]
    All,
    /// The job: the checkpoint is of another policy.
    OtherPolicy,
    /// The job: nothing of the policy's memory was restored.
    NoMemory,
}

impl Restored {
    /// A line for the log.
    pub fn line(self) -> &'static str {
        match self {
            Self::All => "[task] resumed from its checkpoint",
            Self::OtherPolicy => "[task] another policy took over the job",
            Self::NoMemory => {
                "[task] the policy starts again: nothing of its memory was kept; the job continues"
            }
        }
    }
}

impl Task {
    /// The whole state of the task, as plain bytes; see [`Task::restore`].
    pub fn checkpoint(&self) -> Vec<u8> {
        checkpoint::to_bytes(&TaskCheckpoint {
            version: VERSION,
            demo: self.demo.clone(),
            policy: self.name.clone(),
            job: self.job.clone(),
            phase: self.phase.as_str().to_owned(),
            clock: self.clock.clone(),
            panel: self.panel.clone(),
            goals: self.out.book().clone(),
            breakpoints: self.breakpoints.clone(),
            unsure: self.unsure,
            policy_state: self.policy.save(),
        })
    }

    /// Restores what [`Task::checkpoint`] returned. The checkpoint of another policy of the
    /// same demo is accepted, too: its job is resumed, with the object in the gripper.
    ///
    /// # Errors
    /// [`CheckpointError`] for a checkpoint that is damaged, of another version or of another
    /// cell. The task is unchanged then, except that a policy whose own bytes do not decode
    /// is reset.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), CheckpointError> {
        // The version is read before the rest, whose layout it determines.
        let found = checkpoint::version(bytes)?;
        if found != VERSION {
            return Err(CheckpointError::Version { found });
        }
        let saved: TaskCheckpoint = checkpoint::from_bytes(bytes)?;
        // An edited cell with another number of objects would give indices another meaning.
        if saved.demo != self.demo || !saved.job.fits(self.job.attempts.len()) {
            return Err(CheckpointError::OtherCell {
                found: saved.demo,
                expected: self.demo.clone(),
            });
        }
        // Checked before the first assignment. A policy whose own bytes do not decode is reset,
        // all else is unchanged.
        if !saved.is_sound() {
            let wrong = "it counts further than a run can get";
            return Err(bincode::Error::custom(wrong).into());
        }
        let same_policy = saved.policy == self.name;
        if same_policy {
            // The memory of another policy is not readable for this one, its job is: that is
            // why the job is kept apart from the memory.
            self.policy.restore(&saved.policy_state)?;
            self.phase = Text::new(&saved.phase);
        } else {
            self.policy.reset();
            self.phase = Text::EMPTY;
        }
        self.job.take(saved.job);
        self.clock = saved.clock;
        self.panel = saved.panel;
        self.breakpoints = saved.breakpoints;
        *self.out.book_mut() = saved.goals;
        // The sentence is not in the checkpoint; one of before would explain another failure.
        self.out.forget_message();
        // Another policy has an empty memory and may have an object in the gripper.
        self.unsure = saved.unsure || !same_policy;
        self.restored = match (same_policy, self.policy.has_resumed()) {
            (false, _) => Restored::OtherPolicy,
            (true, false) => Restored::NoMemory,
            (true, true) => Restored::All,
        };
        // After the policy: another one, or one without a memory, enters its phases again.
        if self.restored == Restored::All {
            self.tracer.resume(self.policy.as_ref());
        }
        Ok(())
    }

    /// What [`Task::restore`] took from the checkpoint, until the next decision.
    pub fn restored(&self) -> Restored {
        self.restored
    }

    /// To be called once, before the next decision, when decisions were missed: that decision
    /// then compares the checkpoint (the held object, the goals reached) with the
    /// observation. The time without decisions, up to `state`, does not count as time of a
    /// phase: the arm held.
    pub fn reconcile(&mut self, state: &WorldState) {
        self.clock.skip_to(state.header.tick);
        self.unsure = true;
    }

    /// Resets everything: the world is another one, and ticks start from zero.
    pub fn begin_new_scene(&mut self) {
        self.policy.reset();
        // The goal numbers continue: a controller that was not restarted has latched the old
        // ones.
        self.job.reset();
        self.phase = Text::EMPTY;
        self.out.book_mut().forget();
        self.out.forget_message();
        self.panel = PanelState::default();
        self.clock = PolicyClock::default();
        self.unsure = true;
    }
}
