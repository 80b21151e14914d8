//! The inputs and outputs of a policy in one decision.

use behavior::suggest;
use ipc_types::{MAX_ARMS, Wire, WorldState};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robocell_skills::{ArmMemory, Setup, Told, World};
use robocell_task::observation::ControllerEcho;
use robocell_task::{Job, Observation, Output, PolicyTime};

/// The inputs and outputs of a policy in one decision.
pub(crate) struct Decision {
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
    /// It is under way.
    pub(crate) open: bool,
}

impl Decision {
    /// Before the first one.
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
        }
    }

    /// Shows a state between two decisions.
    pub(crate) fn show(&mut self, state: &WorldState) {
        *self.state = *state;
    }

    /// Controlled joints of an arm.
    pub(crate) fn joint_count(&self, arm: usize) -> usize {
        let arm = self.state.arms().get(arm);
        arm.map_or(0, |arm| arm.joint_count as usize)
    }

    /// Takes the inputs of a decision at its start.
    pub(crate) fn begin(&mut self, seen: &Observation<'_>, job: &mut Job, out: &mut Output) {
        *self.state = *seen.state();
        for (arm, echo) in self.echoes.iter_mut().enumerate() {
            *echo = seen.echo(arm);
        }
        self.time = seen.time();
        self.told = [Told::default(); MAX_ARMS];
        self.open = true;
        // Moved in until `end`: the objects of Python share this value and cannot hold a borrow.
        std::mem::swap(&mut self.job, job);
        std::mem::swap(&mut self.out, out);
    }

    /// Returns the job and the output that [`Decision::begin`] took. With `finish`, arms without a
    /// command stay where they are, and drops are counted.
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
        // A world lives for one call: the next one of this decision continues from here.
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
        // A mask has 64 bits; a shift by more would overflow.
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
