//! A task across the restarts of its process and of physics.
//!
//! Before it decides on a state, a task may have to start a new scene, to resume from a
//! checkpoint, or to reconcile with its observation. [`Decider`] holds that rule for
//! every program that runs tasks: the process on the bus, a cell in one process and the
//! verification of recordings. A second copy of the rule would compute other decisions.
//!
//! What can go wrong here:
//! - physics was killed and resumed from an older state, but the task kept its memory: it
//!   would believe in placed objects that are on the table again. Each state that physics
//!   saves has its own checkpoint of the task ([`History`]);
//! - the task was killed alone: its newest checkpoint is younger than the state it sees, and
//!   the scene continues without a gap or with a few missed decisions;
//! - a checkpoint is used for the wrong timeline: generation and tick are compared, and a
//!   task that is ahead of the resumed state is restored or starts from its observation.
//!
//! A change must keep two properties, which tests check by kills at every tick: all programs
//! call [`Decider::begin`] before each decision, and `keep` runs before the decision on the
//! same state. Otherwise a replay restores another checkpoint than the run did.

use ipc_types::{ArmStatus, Decision, WorldState};

use crate::Task;
use crate::checkpoint::CheckpointError;
use crate::inputs::{MISSED_TICKS, name_inputs};
use crate::output::TraceLineText;

/// A checkpoint and the state that it belongs to.
pub struct Kept {
    /// Tick of the state that it was the newest checkpoint for.
    pub tick: u64,
    /// The checkpoint.
    pub checkpoint: Vec<u8>,
}

/// Checkpoints for the states that physics saves.
pub trait History {
    /// The checkpoint for the state of `tick`, or the newest before that.
    fn at(&self, tick: u64) -> Option<Kept>;

    /// Physics saves the state of `tick`: the present `checkpoint` belongs to it. A
    /// restarted physics resumes from the state of `saved_tick`, or from this one; other
    /// checkpoints are not needed any more.
    fn keep(&mut self, tick: u64, saved_tick: u64, checkpoint: &dyn Fn() -> Vec<u8>);
}

/// No checkpoints: physics is started once.
pub struct NoHistory;

impl History for NoHistory {
    fn at(&self, _tick: u64) -> Option<Kept> {
        None
    }

    fn keep(&mut self, _tick: u64, _saved_tick: u64, _checkpoint: &dyn Fn() -> Vec<u8>) {}
}

/// What preceded a decision.
#[derive(Debug)]
pub enum Begun {
    /// Nothing: it follows the decision before.
    Continued,
    /// Decisions were missed; the task reconciles its memory with the observation.
    Reconciled,
    /// Physics resumed from a state it saved, and the task from its checkpoint for it.
    Resumed,
    /// A new scene.
    NewScene,
    /// A new scene, since the checkpoint could not be used.
    Lost(CheckpointError),
}

/// A task and the state it decided on last.
pub struct Decider {
    /// The task.
    pub task: Task,
    /// Whether the task has a scene: one that it started, or that of a checkpoint.
    has_scene: bool,
    /// Generation of physics and tick decided on last.
    decided: Option<(u32, u64)>,
    /// Generation of physics and tick of the saved state that the history has a
    /// checkpoint for.
    kept: Option<(u32, u64)>,
}

impl Decider {
    /// `task`, before its first decision.
    pub fn new(task: Task) -> Self {
        Self {
            task,
            has_scene: false,
            decided: None,
            kept: None,
        }
    }

    /// Restores the task from the checkpoint of its decision on `decided` (generation of
    /// physics and tick), or from one before its first decision, without a gap.
    ///
    /// # Errors
    /// As [`Task::restore`].
    pub fn restore(
        &mut self,
        checkpoint: &[u8],
        decided: Option<(u32, u64)>,
    ) -> Result<(), CheckpointError> {
        // Also where the restore fails: the task then continues from its observation, and must
        // not start a new scene, which would forget what the panel and the gripper show.
        self.has_scene = true;
        self.task.restore(checkpoint)?;
        self.decided = decided;
        Ok(())
    }

    /// Generation of physics and tick decided on last.
    pub fn decided(&self) -> Option<(u32, u64)> {
        self.decided
    }

    /// Resumes from the checkpoint that the previous process wrote with its decision on
    /// `decided`; the present state is `state`.
    ///
    /// # Errors
    /// As [`Task::restore`]; the task then starts from its observation.
    pub fn resume(
        &mut self,
        checkpoint: &[u8],
        decided: (u32, u64),
        state: &WorldState,
    ) -> Result<(), CheckpointError> {
        self.restore(checkpoint, Some(decided))?;
        // One decision later is the ordinary next one. With more in between the world has moved
        // on without the task, and its memory has to be compared with it.
        let decisions = |tick: u64| tick / ipc_types::DECISION_TICKS;
        if decisions(state.header.tick) > decisions(decided.1).saturating_add(1) {
            self.task.reconcile(state);
        }
        Ok(())
    }

    /// Called before each decision on `state`: starts a scene, resumes or reconciles.
    pub fn begin(&mut self, state: &WorldState, history: &mut dyn History) -> Begun {
        let (generation, tick) = (state.header.generation, state.header.tick);
        let begun = match self.decided {
            // The order of the arms matters: a scene comes first, since ticks of another
            // generation of physics cannot be compared with ours.
            _ if !self.has_scene => self.begin_scene(state, history),
            Some((known, _)) if known != generation => self.begin_scene(state, history),
            // This process was stopped for a while (SIGSTOP, a debugger, a busy machine).
            Some((_, last)) if tick > last.saturating_add(MISSED_TICKS) => {
                self.task.reconcile(state);
                Begun::Reconciled
            }
            _ => Begun::Continued,
        };
        self.keep(state, history, matches!(begun, Begun::Resumed));
        begun
    }

    /// Physics was started: it has a state that its predecessor saved, or a new scene.
    fn begin_scene(&mut self, state: &WorldState, history: &dyn History) -> Begun {
        self.has_scene = true;
        // Zero means that physics did not resume: there is no state a checkpoint could belong
        // to.
        let tick = state.resumed_tick;
        let kept = history.at(tick).filter(|_| tick > 0);
        let is_exact = kept.as_ref().is_some_and(|kept| kept.tick == tick);
        // The task is not younger than the state: there is no decision to undo.
        let is_current = tick > 0 && self.decided.is_some_and(|(_, last)| last <= tick);
        // A task that is not ahead of the state keeps its own memory, which is newer than the
        // checkpoint of an earlier state.
        if let Some(kept) = kept.filter(|_| is_exact || !is_current) {
            if let Err(error) = self.task.restore(&kept.checkpoint) {
                self.task.begin_new_scene();
                return Begun::Lost(error);
            }
        } else if !is_current {
            self.task.begin_new_scene();
            return Begun::NewScene;
        }
        // Even an exact checkpoint misses the decision on the saved state and what the arms
        // did.
        self.task.reconcile(state);
        Begun::Resumed
    }

    /// Keeps the checkpoint of the last decision before a saved state: the task resumes from
    /// it together with that state. `has_resumed` if its memory was just found to belong to the
    /// state that physics resumed from.
    fn keep(&mut self, state: &WorldState, history: &mut dyn History, has_resumed: bool) {
        let saving = (state.header.generation, state.saving_tick);
        // Each saved state once: the state message repeats `saving_tick` until the next save.
        if state.saving_tick == 0 || self.kept == Some(saving) {
            return;
        }
        self.kept = Some(saving);
        // A checkpoint of another generation, or of a decision after the saved state, would
        // give the resumed task a memory of things that have not happened.
        let decided = self.decided;
        let is_ours = |tick| match decided {
            Some((generation, last)) => (generation == saving.0 || has_resumed) && last <= tick,
            // A new process, with the checkpoint of the one before.
            None => has_resumed,
        };
        let saved = state.saved_tick;
        // A task that was away while that state was saved; without this a kill would take the
        // task back to its checkpoint for the state before.
        let was_away = saved < saving.1 && is_ours(saved);
        if was_away && history.at(saved).is_none_or(|kept| kept.tick != saved) {
            history.keep(saved, saved, &|| self.task.checkpoint());
        }
        if is_ours(saving.1) {
            history.keep(saving.1, saved, &|| self.task.checkpoint());
        }
    }

    /// Decides on `state`, for which [`Decider::begin`] was called.
    pub fn decide(
        &mut self,
        state: &WorldState,
        statuses: &[Option<&ArmStatus>],
        out: &mut Decision,
        trace: &mut Vec<TraceLineText>,
    ) {
        self.task.decide(state, statuses, out, trace);
        // The inputs are part of the message, so that a replay feeds the same ones.
        name_inputs(&mut out.header, state, statuses);
        self.decided = Some((state.header.generation, state.header.tick));
    }
}
