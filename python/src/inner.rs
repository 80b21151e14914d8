//! What a policy sees and says in one decision, and between decisions what the arms and the
//! equipment of a cell without a policy were told.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use behavior::suggest;
use ipc_types::{MAX_ARMS, Wire, WorldState};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use robocell_skills::{ArmMemory, Setup, Told, World};
use robocell_task::observation::ControllerEcho;
use robocell_task::{Job, Observation, Output, PolicyTime};
use serde::{Deserialize, Serialize};

use crate::command::Command;
use crate::skill::Status;

/// What the equipment was asked for outside of decisions.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Asked {
    pub(crate) conveyor: Option<bool>,
    pub(crate) bins: u32,
    pub(crate) parts: u32,
}

/// What a policy sees and says in one decision.
pub(crate) struct Inner {
    pub(crate) setup: Setup,
    pub(crate) state: Box<WorldState>,
    echoes: [Option<ControllerEcho>; MAX_ARMS],
    pub(crate) time: PolicyTime,
    pub(crate) job: Job,
    pub(crate) out: Output,
    /// By arm; empty for one arm, which the job remembers.
    pub(crate) memories: Vec<ArmMemory>,
    told: [Told; MAX_ARMS],
    /// Timers of skills start again: decisions were missed.
    pub(crate) resumed: bool,
    /// A decision is under way.
    open: bool,
    /// By arm, what it was told outside of decisions; empty where a policy decides.
    kept: Vec<Option<Command>>,
    /// What the equipment is asked for by the next decision.
    pub(crate) asked: Asked,
}

impl Inner {
    /// Before the first decision.
    pub(crate) fn new(setup: Setup) -> Self {
        let arms = setup.arms.len();
        Self {
            setup,
            state: Box::new(WorldState::zeroed()),
            echoes: [None; MAX_ARMS],
            time: PolicyTime::default(),
            job: Job::default(),
            out: Output::default(),
            memories: vec![ArmMemory::default(); if arms > 1 { arms } else { 0 }],
            told: [Told::default(); MAX_ARMS],
            resumed: false,
            open: false,
            kept: Vec::new(),
            asked: Asked::default(),
        }
    }

    /// As [`Inner::new`], for a cell whose arms are told outside of decisions.
    pub(crate) fn told_outside(setup: Setup) -> Self {
        let kept = vec![None; setup.arms.len()];
        Self {
            kept,
            ..Self::new(setup)
        }
    }

    /// Shows a state between two decisions.
    pub(crate) fn show(&mut self, state: &WorldState) {
        *self.state = *state;
    }

    /// Gives an arm a command: in this decision, or from the next one on.
    pub(crate) fn tell(&mut self, arm: usize, mut command: Command) -> PyResult<()> {
        if self.open {
            return command.give(self, arm);
        }
        match self.kept.get_mut(arm) {
            Some(kept) => {
                *kept = Some(command);
                Ok(())
            }
            None => Err(outside()),
        }
    }

    /// Gives every arm, and the equipment, what they were told outside of decisions.
    pub(crate) fn give_kept(&mut self) -> PyResult<()> {
        self.give_asked();
        let mut kept = std::mem::take(&mut self.kept);
        let told = kept.iter_mut().enumerate();
        let given = told
            .filter_map(|(arm, command)| Some((arm, command.as_mut()?)))
            .try_for_each(|(arm, command)| command.give(self, arm));
        self.kept = kept;
        given
    }

    fn give_asked(&mut self) {
        let asked = std::mem::take(&mut self.asked);
        let io = &mut self.job.io;
        io.conveyor_running = asked.conveyor.unwrap_or(io.conveyor_running);
        io.add_bin = io.add_bin.wrapping_add(asked.bins);
        io.drop_parts = io.drop_parts.wrapping_add(asked.parts);
    }

    /// Asks the equipment: in this decision, or in the next one.
    pub(crate) fn ask(&mut self, ask: impl FnOnce(&mut Asked)) -> PyResult<()> {
        if !self.open && self.kept.is_empty() {
            return Err(outside());
        }
        ask(&mut self.asked);
        if self.open {
            self.give_asked();
        }
        Ok(())
    }

    /// What the arms were told outside of decisions.
    pub(crate) fn kept(&self) -> &[Option<Command>] {
        &self.kept
    }

    /// Takes back what [`Inner::kept`] gave.
    pub(crate) fn keep(&mut self, kept: Vec<Option<Command>>) {
        if kept.len() == self.kept.len() {
            self.kept = kept;
        }
    }

    /// How the skill that an arm was told ended.
    pub(crate) fn skill_status(&self, arm: usize) -> Option<Status> {
        match self.kept.get(arm)?.as_ref()? {
            Command::Skill(_, ended) => Some(ended.unwrap_or(Status::RUNNING)),
            _ => None,
        }
    }

    /// Controlled joints of an arm.
    pub(crate) fn joint_count(&self, arm: usize) -> usize {
        let arm = self.state.arms().get(arm);
        arm.map_or(0, |arm| arm.joint_count as usize)
    }

    /// Takes what a decision begins with.
    pub(crate) fn begin(&mut self, seen: &Observation<'_>, job: &mut Job, out: &mut Output) {
        *self.state = *seen.state();
        for (arm, echo) in self.echoes.iter_mut().enumerate() {
            *echo = seen.echo(arm);
        }
        self.time = seen.time();
        self.told = [Told::default(); MAX_ARMS];
        self.open = true;
        std::mem::swap(&mut self.job, job);
        std::mem::swap(&mut self.out, out);
    }

    /// Gives back what [`Inner::begin`] took. With `finish`, arms without a command
    /// stay where they are, and drops are counted.
    pub(crate) fn end(&mut self, finish: bool, job: &mut Job, out: &mut Output) {
        if finish {
            (0..self.setup.arms.len()).for_each(|arm| self.world(arm, |world| world.finish()));
            self.resumed = false;
        }
        self.open = false;
        std::mem::swap(&mut self.job, job);
        std::mem::swap(&mut self.out, out);
    }

    /// The view of one arm, as skills use it.
    pub(crate) fn world<R>(&mut self, arm: usize, work: impl FnOnce(&mut World<'_>) -> R) -> R {
        let observation = Observation::with_echoes(&self.state, self.echoes, self.time);
        let mut world = World::new(&self.setup, &observation, &mut self.job, &mut self.out, arm);
        world.resumed = self.resumed;
        world.memory = self.memories.get_mut(arm);
        world.told = self.told.get(arm).copied().unwrap_or_default();
        let result = work(&mut world);
        let told = world.told;
        if let Some(slot) = self.told.get_mut(arm) {
            *slot = told;
        }
        result
    }

    /// Index of an object.
    pub(crate) fn object(&self, name: &str) -> PyResult<usize> {
        let names = || self.setup.objects.iter().map(|o| o.name.as_str()).collect();
        found("object", name, self.setup.object(name), names)
    }

    /// Bit of an obstacle.
    pub(crate) fn obstacle(&self, name: &str) -> PyResult<u64> {
        let names = &self.setup.obstacles;
        let index = names.iter().position(|known| known == name);
        let known = || names.iter().map(String::as_str).collect();
        found("obstacle", name, index.filter(|index| *index < 64), known).map(|index| 1 << index)
    }

    /// Index of a place.
    pub(crate) fn place(&self, name: &str) -> PyResult<usize> {
        let names = || self.setup.places.iter().map(|p| p.name.as_str()).collect();
        found("place", name, self.setup.place(name), names)
    }
}

fn found<'a>(
    what: &str,
    name: &str,
    index: Option<usize>,
    names: impl FnOnce() -> Vec<&'a str>,
) -> PyResult<usize> {
    index.ok_or_else(|| {
        let advice = suggest::advice(name, &names());
        PyValueError::new_err(format!("unknown {what} '{name}'; {advice}"))
    })
}

/// What Python and the policy share.
pub(crate) type Shared = Arc<Mutex<Inner>>;

/// Locks it. A decision that failed leaves nothing half done that matters.
pub(crate) fn lock(shared: &Shared) -> MutexGuard<'_, Inner> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Locks it for a command.
///
/// # Errors
/// Outside of a decision.
pub(crate) fn lock_open(shared: &Shared) -> PyResult<MutexGuard<'_, Inner>> {
    let inner = lock(shared);
    if inner.open {
        return Ok(inner);
    }
    Err(outside())
}

fn outside() -> PyErr {
    PyRuntimeError::new_err("a cell takes commands only while decide() or reconcile() runs")
}
