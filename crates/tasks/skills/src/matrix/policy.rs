//! The policy of a matrix job.

use std::sync::Arc;

use behavior::machine::Fault;
use behavior::matrix::{Cell as MatrixCell, Definition, EventId, EventSet, HandlerId, Handlers};
use behavior::matrix::{Next, Table, Vocabulary};
use behavior::numbers::Numbers;
use behavior::{Graph, NodeStatus};
use cell_model::Cell;
use ipc_types::{Pose, Text};
use robocell_task::settings::behaviour_text;
use robocell_task::{AnyPolicy, Job, Observation, Output, SetupError};

use super::arm::{ArmMemory, ArmNumbers};
use super::job::{MatrixJob, Turn};
use super::run::MatrixRun;
use crate::named::Named;
use crate::path::Reached;
use crate::setup::{ARM, Setup};
use crate::suction::GripChange;
use crate::world::World;

/// The policy of `job` with the matrix in `file`, beside the cell file.
///
/// # Errors
/// Returns a [`SetupError`] with all errors of the file.
pub fn policy<J: MatrixJob>(
    job: J,
    cell: &Cell,
    file: &str,
) -> Result<Box<dyn AnyPolicy>, SetupError> {
    let text = behaviour_text(cell, file)?;
    let loaded = load::<J>(&cell.name_of(file), &text);
    let (table, arm, own) = loaded.map_err(SetupError::in_file)?;
    let fixed = Fixed {
        setup: Setup::new(cell, []),
        job,
        arm,
        own,
    };
    Ok(Box::new(MatrixPolicy {
        fixed,
        run: MatrixRun::new(Arc::new(table)),
        arm: ArmMemory::new(),
        memory: J::Memory::default(),
    }))
}

/// The matrix and the numbers in the text of a behaviour file.
///
/// # Errors
/// Returns all errors with line and column: an event, a state or a handler without an
/// implementation, and a number that is unknown, missing or out of range.
pub fn load<J: MatrixJob>(
    file: &str,
    text: &str,
) -> Result<(Table, ArmNumbers, J::Numbers), String> {
    let events: Vec<&str> = J::EVENTS.iter().map(|(name, _)| *name).collect();
    let handlers: Vec<&str> = J::HANDLERS.iter().map(|(name, _)| *name).collect();
    let vocabulary = Vocabulary {
        events: &events,
        states: J::State::NAMES,
        handlers: &handlers,
        behaviors: &[],
    };
    let table = Definition::load(file, text, &vocabulary).map_err(|why| why.to_string())?;
    let mut numbers = Numbers::read(file, text).map_err(|why| why.to_string())?;
    let arm = ArmNumbers::read::<J::State>(&mut numbers);
    let own = J::numbers(&mut numbers);
    // After all readers: a number that none of them has read is a misspelt one.
    numbers.finish().map_err(|why| why.to_string())?;
    Ok((table, arm, own))
}

/// The parts that do not change while a job runs.
struct Fixed<J: MatrixJob> {
    job: J,
    setup: Setup,
    arm: ArmNumbers,
    own: J::Numbers,
}

struct MatrixPolicy<J: MatrixJob> {
    fixed: Fixed<J>,
    run: MatrixRun,
    arm: ArmMemory,
    memory: J::Memory,
}

impl<J: MatrixJob> MatrixPolicy<J> {
    /// The matrix and a decision of it; `None` if the observation has no arm.
    fn turn<'t>(
        &'t mut self,
        observation: &'t Observation<'t>,
        job: &'t mut Job,
        out: &'t mut Output,
    ) -> Option<(&'t mut MatrixRun, Turn<'t, J>)> {
        let state = self.run.state()?;
        let world = World::new(&self.fixed.setup, observation, job, out, ARM);
        let memories = (&mut self.arm, &mut self.memory);
        Some((&mut self.run, turn(&self.fixed, state, memories, world)?))
    }
}

fn turn<'t, J: MatrixJob>(
    fixed: &'t Fixed<J>,
    state: J::State,
    (arm, memory): (&'t mut ArmMemory, &'t mut J::Memory),
    world: World<'t>,
) -> Option<Turn<'t, J>> {
    let seen = world.observation.arm(ARM)?;
    Some(Turn {
        of: &fixed.job,
        own: &fixed.own,
        numbers: &fixed.arm,
        arm,
        memory,
        state,
        now: world.now(),
        tcp: seen.tcp,
        gripper: &seen.gripper,
        grip: GripChange::default(),
        reached: Reached::Nothing,
        world,
    })
}

/// Handles one event.
fn step<J: MatrixJob>(run: &mut MatrixRun, turn: &mut Turn<'_, J>) {
    // The grip first: conditions of events compare it with the decision before.
    turn.grip = turn.arm.grip.update(turn.gripper);
    // During a pause nothing is reached, so that an event of arrival is not raised twice.
    if turn.now >= turn.arm.wait_until {
        let precision = turn.numbers.precision(turn.state);
        turn.reached = turn.arm.path.step(&turn.tcp, precision, turn.now);
    }
    J::observe(turn);
    let mut pending = EventSet::EMPTY;
    for (id, (_, is_pending)) in (0_u16..).zip(J::EVENTS) {
        if is_pending(turn) {
            pending = pending.with(EventId(id));
        }
    }
    let handled = run.handle(pending, &mut Host(turn));
    if run.tell(handled, turn.world.out) {
        // The time of a state starts with its entry, also where it is entered from itself.
        turn.arm.since = turn.now;
        turn.world.job.counters.phase_entry += 1;
    }
    if let Some(state) = run.state() {
        turn.state = state;
    }
}

struct Host<'h, 't, J: MatrixJob>(&'h mut Turn<'t, J>);

impl<J: MatrixJob> Handlers for Host<'_, '_, J> {
    fn handle(&mut self, handler: HandlerId, _cell: MatrixCell<'_>) -> Result<Next, Fault> {
        let handler = J::HANDLERS.get(usize::from(handler.0)).ok_or(Fault {
            reason: "unknown handler",
        })?;
        Ok(handler.1(self.0))
    }
}

impl<J: MatrixJob> AnyPolicy for MatrixPolicy<J> {
    fn reset(&mut self) {
        self.run.reset();
        self.arm = ArmMemory::new();
        self.memory = J::Memory::default();
        J::reset(&mut self.memory);
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let Some((run, mut turn)) = self.turn(observation, job, out) else {
            return;
        };
        step(run, &mut turn);
        let intent = turn.arm.path.intent(turn.arm.gripper(), turn.now);
        turn.world.out.arm(ARM, intent);
        // Rebuilt by `report` in each decision from the observation.
        turn.world.job.placed.clear();
        J::report(&mut turn);
        turn.world.out.phase = run.phase();
    }

    fn tend(&self, observation: &Observation<'_>, job: &mut Job) {
        // Output and memories are thrown away: only requests to the equipment, in the job,
        // remain.
        let mut out = Output::default();
        let (mut arm, mut memory) = (ArmMemory::default(), J::Memory::default());
        let world = World::new(&self.fixed.setup, observation, job, &mut out, ARM);
        let state = self.run.state();
        let turn = state.and_then(|s| turn(&self.fixed, s, (&mut arm, &mut memory), world));
        if let Some(mut turn) = turn {
            J::tend(&mut turn);
        }
    }

    fn phase(&self) -> Text<32> {
        self.run.phase()
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        self.run.describe()
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        self.run.statuses(out);
    }

    fn save(&self) -> Vec<u8> {
        self.run.save(&(&self.arm, &self.memory))
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let job = &self.fixed.job;
        // Both memories are checked before the matrix is restored, so an error changes nothing.
        let sound = |(arm, memory): &(ArmMemory, J::Memory)| arm.is_sound() && job.is_sound(memory);
        (self.arm, self.memory) = self.run.restore(bytes, sound)?;
        Ok(())
    }

    fn default_pose(&self, arm: usize) -> Option<Pose> {
        self.fixed.job.default_pose().filter(|_| arm == ARM)
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let Some((run, mut turn)) = self.turn(observation, job, out) else {
            return;
        };
        // The state has its full time again after any gap.
        turn.arm.since = turn.now;
        let next = J::reconcile(&mut turn);
        if run.set(next) {
            turn.world.job.counters.phase_entry += 1;
        }
    }
}
