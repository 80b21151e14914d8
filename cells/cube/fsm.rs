//! Put the cube on the mark, as a state machine without a library: each state
//! knows its skill and its successor, two edges leave the ring.

use std::sync::Arc;

use robocell_skills::{Close, Condition, MoveTo, Open, Progress, Setup, Skill, Status, World};
use robocell_task::{Job, Observation, Output, Policy};
use serde::{Deserialize, Serialize};

/// The machine.
pub(crate) struct Fsm {
    pub(crate) setup: Arc<Setup>,
    pub(crate) cube: usize,
    pub(crate) mark: usize,
}

/// The states, in the order of the ring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) enum State {
    #[default]
    Above,
    Down,
    Grasp,
    Lift,
    Carry,
    Lower,
    Release,
    Retract,
}

use State::{Above, Carry, Down, Grasp, Lift, Lower, Release, Retract};

const RING: [State; 8] = [Above, Down, Grasp, Lift, Carry, Lower, Release, Retract];
const NAMES: [&str; 8] = [
    "above", "down", "grasp", "lift", "carry", "lower", "release", "retract",
];

impl State {
    fn next(self) -> Self {
        RING.get(self as usize + 1).copied().unwrap_or(self)
    }
}

impl Fsm {
    fn run(&self, state: State, progress: &mut Progress, arm: &mut World<'_>) -> Status {
        let (cube, mark) = (self.cube, self.mark);
        match state {
            Above | Retract => MoveTo::object(cube, 0.1).step(progress, arm),
            Down => MoveTo::object(cube, 0.0).step(progress, arm),
            Grasp => Close { object: Some(cube) }.step(progress, arm),
            Lift => MoveTo::up(0.1).holding(cube).step(progress, arm),
            Carry => MoveTo::place(cube, mark, 0.1).step(progress, arm),
            Lower => MoveTo::place(cube, mark, 0.0).step(progress, arm),
            Release => Open.step(progress, arm),
        }
    }

    /// The edges that leave the ring: what is seen fits another part of it.
    fn interrupt(&self, state: State, arm: &World<'_>) -> Option<State> {
        let on_mark = Condition::At {
            object: self.cube,
            place: self.mark,
            tolerance_m: 0.02,
        };
        let holding = Condition::Holding(Some(self.cube)).holds(arm);
        let wanted = match (on_mark.holds(arm), holding) {
            (true, _) if !matches!(state, Release | Retract) => Release,
            (false, true) if !matches!(state, Lift | Carry | Lower | Release) => Lift,
            (false, false) if !matches!(state, Above | Down | Grasp) => Above,
            _ => return None,
        };
        Some(wanted)
    }
}

impl Policy for Fsm {
    type Memory = (State, Progress);

    fn decide(
        &self,
        (state, progress): &mut (State, Progress),
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let mut arm = World::new(&self.setup, observation, job, out, 0);
        if let Some(wanted) = self.interrupt(*state, &arm) {
            (*state, *progress) = (wanted, Progress::default());
        }
        let status = self.run(*state, progress, &mut arm);
        let done = *state == Retract && status == Status::Success;
        match status {
            Status::Success if !done => (*state, *progress) = (state.next(), Progress::default()),
            Status::Failure => (*state, *progress) = (Above, Progress::default()),
            _ => {}
        }
        arm.finish();
        arm.report(done);
    }

    fn phase(&self, (state, _): &(State, Progress)) -> &str {
        NAMES.get(*state as usize).unwrap_or(&"")
    }

    fn phases(&self) -> &[&str] {
        &NAMES
    }

    /// The edges look at the cell themselves.
    fn reconcile(
        &self,
        (_, progress): &mut (State, Progress),
        _: &Observation<'_>,
        _: &mut Job,
        _: &mut Output,
    ) {
        progress.reset();
    }
}
