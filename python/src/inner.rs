//! The data that Python and a policy share: a decision and, between the decisions of a cell
//! without a policy, the commands for its arms and its equipment.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use robocell_skills::Setup;
use serde::{Deserialize, Serialize};

use crate::command::Command;
use crate::decision::Decision;
use crate::work::Status;

/// Requests to the equipment from outside of decisions.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Asked {
    pub(crate) conveyor: Option<bool>,
    pub(crate) bins: u32,
    pub(crate) parts: u32,
}

/// A decision, and the commands for arms and equipment from outside of decisions.
pub(crate) struct Inner {
    pub(crate) decision: Decision,
    /// By arm, its command from outside of decisions; empty where a policy decides.
    kept: Vec<Option<Command>>,
    /// Requests to the equipment for the next decision.
    pub(crate) asked: Asked,
}

impl Inner {
    /// Before the first decision.
    pub(crate) fn new(setup: Setup) -> Self {
        Self {
            decision: Decision::new(setup),
            kept: Vec::new(),
            asked: Asked::default(),
        }
    }

    /// As [`Inner::new`], for a cell whose arms are commanded from outside of decisions.
    pub(crate) fn told_outside(setup: Setup) -> Self {
        let kept = vec![None; setup.arms.len()];
        Self {
            kept,
            ..Self::new(setup)
        }
    }

    /// Gives an arm a command: in this decision, or from the next one on.
    pub(crate) fn tell(&mut self, arm: usize, mut command: Command) -> PyResult<()> {
        if self.decision.open {
            return command.give(&mut self.decision, arm);
        }
        match self.kept.get_mut(arm) {
            Some(kept) => {
                *kept = Some(command);
                Ok(())
            }
            None => Err(outside()),
        }
    }

    /// Gives every arm, and the equipment, their commands from outside of decisions.
    pub(crate) fn give_kept(&mut self) -> PyResult<()> {
        self.give_asked();
        let mut kept = std::mem::take(&mut self.kept);
        let told = kept.iter_mut().enumerate();
        let given = told
            .filter_map(|(arm, command)| Some((arm, command.as_mut()?)))
            .try_for_each(|(arm, command)| command.give(&mut self.decision, arm));
        self.kept = kept;
        given
    }

    fn give_asked(&mut self) {
        let asked = std::mem::take(&mut self.asked);
        let io = &mut self.decision.job.io;
        io.conveyor_running = asked.conveyor.unwrap_or(io.conveyor_running);
        io.add_bin = io.add_bin.wrapping_add(asked.bins);
        io.drop_parts = io.drop_parts.wrapping_add(asked.parts);
    }

    /// Asks the equipment: in this decision, or in the next one.
    pub(crate) fn ask(&mut self, ask: impl FnOnce(&mut Asked)) -> PyResult<()> {
        if !self.decision.open && self.kept.is_empty() {
            return Err(outside());
        }
        ask(&mut self.asked);
        if self.decision.open {
            self.give_asked();
        }
        Ok(())
    }

    /// The commands for the arms from outside of decisions.
    pub(crate) fn kept(&self) -> &[Option<Command>] {
        &self.kept
    }

    /// Restores the commands that [`Inner::kept`] returned.
    pub(crate) fn keep(&mut self, kept: Vec<Option<Command>>) {
        // A snapshot of another cell, or of one with a policy, has no commands for these arms.
        if kept.len() == self.kept.len() {
            self.kept = kept;
        }
    }

    /// Status of the skill that an arm was given; `None` without one.
    pub(crate) fn skill_status(&self, arm: usize) -> Option<Status> {
        match self.kept.get(arm)?.as_ref()? {
            Command::Skill(_, ended) => Some(ended.unwrap_or(Status::RUNNING)),
            _ => None,
        }
    }
}

/// The data that Python and the policy share.
pub(crate) type Shared = Arc<Mutex<Inner>>;

/// Locks it, also after a panic: a decision that failed leaves nothing half done that matters.
pub(crate) fn lock(shared: &Shared) -> MutexGuard<'_, Inner> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Locks it for a command.
///
/// # Errors
/// Outside of a decision.
pub(crate) fn lock_open(shared: &Shared) -> PyResult<MutexGuard<'_, Inner>> {
    let inner = lock(shared);
    if inner.decision.open {
        return Ok(inner);
    }
    Err(outside())
}

fn outside() -> PyErr {
    PyRuntimeError::new_err("a cell takes commands only while decide() or reconcile() runs")
}
