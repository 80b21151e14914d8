//! A matrix in a file: handlers start steps, and conditions and results are events.

mod checks;

use std::sync::Arc;

use behavior::board::Board;
use behavior::inline::{Inline, Part};
use behavior::machine::{BehaviorId, Fault};
use behavior::matrix::{
    self, Cell as MatrixCell, Definition, EventId, EventSet, HandlerId, Handlers, Next, Vocabulary,
};
use behavior::tree::Tree;
use behavior::{Finding, Graph, NodeStatus, ResetReason, Status};
use cell_model::Cell;
use ipc_types::Text;
use robocell_task::{AnyPolicy, Job, Observation, Output, SetupError};
use serde::de::Error as _;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

use super::dead_ends;
use super::parts::{self, Loader};
use crate::matrix::MatrixRun;
use crate::setup::{ARM, Setup};
use crate::skill::Station;
use crate::world::World;
use checks::{event_named, refuse_dead_ends, refuse_silent_events};

/// See the module.
pub(super) struct MatrixPolicy {
    setup: Arc<Setup>,
    run: MatrixRun,
    parts: Parts,
    /// Conditions with the names of their events, in the order of the file.
    events: Vec<(String, Tree<Station>, EventId)>,
    initial: Vec<u8>,
    resumed: bool,
}

struct Parts {
    /// Steps of the handlers.
    handlers: Vec<Tree<Station>>,
    /// Events for their success and failure.
    results: Vec<[Option<EventId>; 2]>,
    /// Steps that states run.
    sequences: Vec<Tree<Station>>,
    shared: Board,
    /// The handler whose steps are running.
    current: Option<u16>,
}

/// The memory beside the state of the matrix.
#[derive(Serialize, Deserialize)]
struct Record {
    handlers: Vec<ByteBuf>,
    sequences: Vec<ByteBuf>,
    /// By name.
    events: Vec<(String, ByteBuf)>,
    board: ByteBuf,
    current: Option<u16>,
}

impl MatrixPolicy {
    /// Loads the text of a file.
    pub(super) fn load(
        mut loader: Loader<'_>,
        setup: &Arc<Setup>,
        text: &str,
    ) -> Result<Self, SetupError> {
        let definition = Definition::read(loader.file(), text).map_err(Loader::wrong)?;
        let inline = Inline::read(loader.file(), text).map_err(Loader::wrong)?;
        loader.refuse_numbers(text)?;
        let runs: Vec<&str> = definition
            .states
            .iter()
            .filter_map(|state| Some(state.during.as_ref()?.run.text.as_str()))
            .collect();
        let handlers: Vec<&str> = inline.handlers.iter().map(|h| h.name.as_str()).collect();
        // States and events come from the file itself: no host gives them names.
        let vocabulary = Vocabulary {
            events: &[],
            states: &[],
            handlers: &handlers,
            behaviors: &runs,
        };
        let table = definition.compile(&vocabulary).map_err(Loader::wrong)?;
        let event = |name: &str| event_named(&definition, &table, name);
        let results = results_of(&inline.handlers, event)?;
        let mut events = Vec::new();
        for part in &inline.events {
            let id = event(&part.name).map_err(Loader::wrong)?;
            events.push((part.name.clone(), loader.condition(part)?, id));
        }
        let sequences = runs
            .iter()
            .map(|run| loader.named(run, &inline.states))
            .collect::<Result<_, _>>()?;
        // Refused at load: such a cell looks like a reaction that the job has, and never is
        // one.
        refuse_silent_events(&definition, &inline).map_err(Loader::wrong)?;
        refuse_dead_ends(
            &definition,
            &table,
            &dead_ends::ends(&inline, |name| table.state(name)),
        )
        .map_err(Loader::wrong)?;
        let mut policy = Self {
            setup: Arc::clone(setup),
            run: MatrixRun::new(Arc::new(table)),
            parts: Parts {
                handlers: loader.trees(&inline.handlers)?,
                results,
                sequences,
                shared: loader.into_board(),
                current: None,
            },
            events,
            initial: Vec::new(),
            resumed: false,
        };
        policy.initial = policy.save();
        Ok(policy)
    }

    /// Findings about the file with these parts: probable mistakes that are not errors.
    pub(super) fn check(&self, inline: &Inline) -> Vec<Finding> {
        let table = self.run.table();
        let ends = dead_ends::ends(inline, |name| table.state(name));
        let mut found = matrix::check_with_ends(table, &ends);
        found.extend(parts::noted(self.trees()));
        found
    }

    fn trees(&self) -> impl Iterator<Item = &Tree<Station>> {
        let events = self.events.iter().map(|(_, tree, _)| tree);
        let parts = self.parts.handlers.iter().chain(&self.parts.sequences);
        parts.chain(events)
    }

    fn pending(&mut self, world: &mut World<'_>) -> EventSet {
        let mut pending = EventSet::EMPTY;
        for (_, condition, event) in &mut self.events {
            if parts::holds(condition, &mut self.parts.shared, world) {
                pending = pending.with(*event);
            }
        }
        pending
    }

    /// The pending events for which the state has a cell: one without a cell must not keep the
    /// events behind it from being handled.
    fn answered(&self, pending: EventSet) -> EventSet {
        let (table, state) = (self.run.table(), self.run.state_id());
        let known = (0..u16::try_from(behavior::matrix::MAX_EVENTS).unwrap_or(0)).map(EventId);
        known
            .filter(|event| pending.contains(*event) && table.handler(state, *event).is_some())
            .fold(EventSet::EMPTY, EventSet::with)
    }
}

impl Parts {
    /// Runs the steps of the current handler; returns the event of their result.
    fn work(&mut self, world: &mut World<'_>) -> Option<EventId> {
        let current = usize::from(self.current?);
        let tree = self.handlers.get_mut(current)?;
        let status = parts::tick(tree, &mut self.shared, world);
        let [success, failure] = *self.results.get(current)?;
        world.end_refused(status == Status::Failure && failure.is_none());
        // Failed steps start again, unless the file names an event for the failure.
        let over = match status {
            Status::Running => false,
            Status::Success => true,
            Status::Failure => failure.is_some(),
        };
        if !over {
            return None;
        }
        self.current = None;
        if status == Status::Success {
            success
        } else {
            failure
        }
    }
}

struct Running<'p, 'w, 'x> {
    parts: &'p mut Parts,
    world: &'x mut World<'w>,
}

impl Handlers for Running<'_, '_, '_> {
    /// Starts the steps of the handler, unless they are running.
    fn handle(&mut self, handler: HandlerId, cell: MatrixCell<'_>) -> Result<Next, Fault> {
        let Parts {
            handlers,
            shared,
            current,
            ..
        } = self.parts;
        if *current != Some(handler.0) {
            // The former steps are stopped, so that no two handlers command the arm.
            let running = current.replace(handler.0).map(usize::from);
            if let Some(tree) = running.and_then(|running| handlers.get_mut(running)) {
                parts::stop(tree, shared, self.world);
            }
        }
        let next = cell.goto.first();
        Ok(next.map_or(Next::Stay, |state| Next::Goto(*state)))
    }

    fn run(&mut self, behavior: BehaviorId) -> Status {
        match self.parts.sequences.get_mut(behavior.index()) {
            Some(tree) => parts::tick(tree, &mut self.parts.shared, self.world),
            None => Status::Running,
        }
    }

    fn halt(&mut self, behavior: BehaviorId, _reason: ResetReason) -> bool {
        if let Some(tree) = self.parts.sequences.get_mut(behavior.index()) {
            parts::stop(tree, &mut self.parts.shared, self.world);
        }
        true
    }
}

impl MatrixPolicy {
    /// Restores a checkpoint. After an error some parts may have been restored.
    fn take(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let record: Record = self.run.restore(bytes, |_| true)?;
        self.parts
            .shared
            .restore(&record.board)
            .map_err(bincode::Error::custom)?;
        let events = self.events.iter_mut();
        let events = events.map(|(name, tree, _)| (name.as_str(), tree));
        parts::restore_named(events, &record.events)?;
        parts::restore(&mut self.parts.handlers, &record.handlers)?;
        parts::restore(&mut self.parts.sequences, &record.sequences)?;
        self.parts.current = record.current;
        Ok(())
    }
}

impl AnyPolicy for MatrixPolicy {
    fn warnings(&self, cell: &Cell) -> Vec<String> {
        let mut warnings = parts::warnings(self.trees());
        warnings.extend(self.setup.far_picks(cell));
        warnings
    }

    fn reset(&mut self) {
        let initial = std::mem::take(&mut self.initial);
        // It cannot fail: this policy wrote the bytes.
        let _taken = self.take(&initial).is_ok();
        self.initial = initial;
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let mut world = World::new(&setup, observation, job, out, ARM);
        world.resumed = std::mem::take(&mut self.resumed);
        // Conditions are evaluated before the steps: both refer to the same observation.
        let mut pending = self.pending(&mut world);
        let before = self.parts.current;
        if let Some(event) = self.parts.work(&mut world) {
            pending = pending.with(event);
        }
        let pending = self.answered(pending);
        let mut host = Running {
            parts: &mut self.parts,
            world: &mut world,
        };
        let handled = self.run.handle(pending, &mut host);
        // Steps that were started in this decision run in it, too, so the arm does not wait for
        // the next one.
        if self.parts.current != before {
            self.parts.work(&mut world);
        }
        world.finish();
        world.report(self.run.status() == Status::Success);
        self.run.tell(handled, world.out);
        world.out.phase = self.phase();
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
        let mut board = Vec::new();
        self.parts.shared.save(&mut board);
        let events = self.events.iter();
        self.run.save(&Record {
            handlers: parts::save(&self.parts.handlers),
            sequences: parts::save(&self.parts.sequences),
            events: parts::save_named(events.map(|(name, tree, _)| (name.as_str(), tree))),
            board: ByteBuf::from(board),
            current: self.parts.current,
        })
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.take(bytes).inspect_err(|_| self.reset())
    }

    fn reconcile(&mut self, _observation: &Observation<'_>, _job: &mut Job, _out: &mut Output) {
        self.resumed = true;
    }
}

/// Events for the success and failure of each handler.
fn results_of(
    handlers: &[Part],
    event: impl Fn(&str) -> Result<EventId, String>,
) -> Result<Vec<[Option<EventId>; 2]>, SetupError> {
    let mut results = Vec::new();
    for handler in handlers {
        let id = |name: &Option<String>| name.as_deref().map(&event).transpose();
        let both = [id(&handler.success), id(&handler.failure)];
        let [success, failure] = both.map(|id| id.map_err(Loader::wrong));
        results.push([success?, failure?]);
    }
    Ok(results)
}
