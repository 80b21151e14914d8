//! A machine in a file: its states run steps or trees, and its events fire triggers.

mod checkpoint;

use std::collections::BTreeSet;
use std::sync::Arc;

use behavior::board::Board;
use behavior::inline::{Inline, Part};
use behavior::machine::{
    self, Actions, BehaviorId, CallbackId, Definition, DuringDef, Event, Fault, GuardId, StateDef,
    Table, TriggerId, Vocabulary,
};
use behavior::tree::Tree;
use behavior::{Finding, Graph, NodeStatus, ResetReason, Status};
use cell_model::Cell;
use ipc_types::Text;
use robocell_task::{AnyPolicy, Job, Observation, Output, SetupError, TraceEvent};

use super::dead_ends;
use super::parts::{self, Loader};
use crate::machine_run::MachineRun;
use crate::setup::{ARM, Setup};
use crate::skill::Station;
use crate::world::World;

/// See the module.
pub(super) struct MachinePolicy {
    setup: Arc<Setup>,
    job: MachineJob,
    resumed: bool,
}

/// A machine with everything that its states run.
pub(super) struct MachineJob {
    run: MachineRun,
    parts: Parts,
    /// In the order of the file.
    events: Vec<Condition>,
    /// Checkpoint of the machine before its first tick.
    initial: Vec<u8>,
}

/// A condition that fires a trigger.
struct Condition {
    name: String,
    trigger: TriggerId,
    tree: Tree<Station>,
    /// Whether it fired and has held in every decision since. It does not enter a state again
    /// that is already active, or it would be entered a hundred times a second.
    has_fired: bool,
}

/// The trees that the machine runs and evaluates.
struct Parts {
    sequences: Vec<Tree<Station>>,
    /// By sequence: whether failed steps start again, because the file names no trigger for it.
    repeats: Vec<bool>,
    /// Guards with their names, in the order of the file.
    conditions: Vec<(String, Tree<Station>)>,
    shared: Board,
}

impl MachinePolicy {
    /// Loads the text of a file.
    pub(super) fn load(
        loader: Loader<'_>,
        setup: &Arc<Setup>,
        text: &str,
    ) -> Result<Self, SetupError> {
        Ok(Self {
            setup: Arc::clone(setup),
            job: MachineJob::load(loader, text)?,
            resumed: false,
        })
    }
}

impl MachineJob {
    /// Loads the text of a file.
    pub(super) fn load(mut loader: Loader<'_>, text: &str) -> Result<Self, SetupError> {
        let definition = Definition::read(loader.file(), text).map_err(Loader::wrong)?;
        let inline = Inline::read(loader.file(), text).map_err(Loader::wrong)?;
        loader.refuse_numbers(text)?;
        let mut runs = Vec::new();
        // Nested states run steps, too, so all levels are visited.
        all_states(&definition.states, &mut |state| {
            runs.extend(state.during.clone());
        });
        let run_names: Vec<&str> = runs.iter().map(|run| run.run.text.as_str()).collect();
        let condition_names = names(&inline.conditions);
        // The order of these lists is that of the ids in the compiled table: guards and runs
        // are found by it.
        let event_names = names(&inline.events);
        let triggers = triggers(&event_names, &runs);
        let vocabulary = Vocabulary {
            triggers: &triggers,
            guards: &condition_names,
            callbacks: &[],
            behaviors: &run_names,
        };
        let table = definition.compile(&vocabulary).map_err(Loader::wrong)?;
        let fired = dead_ends::Fired {
            events: &event_names,
            ends: &dead_ends::ends(&inline, |name| table.state(name)),
        };
        // Refused at load, before trees are built: the message has the place in the file.
        fired
            .refuse_dead_ends(&definition, &table)
            .map_err(Loader::wrong)?;
        let sequences = runs
            .iter()
            .map(|run| loader.named(&run.run.text, &inline.states))
            .collect::<Result<_, _>>()?;
        let conditions = inline.conditions.iter();
        let conditions = conditions
            .map(|part| Ok((part.name.clone(), loader.condition(part)?)))
            .collect::<Result<_, SetupError>>()?;
        let events = events_of(&inline.events, &table, &mut loader)?;
        let mut job = Self {
            run: MachineRun::new(Arc::new(table)),
            parts: Parts {
                sequences,
                repeats: runs.iter().map(|run| run.failure.is_none()).collect(),
                conditions,
                shared: loader.into_board(),
            },
            events,
            initial: Vec::new(),
        };
        job.initial = job.save();
        Ok(job)
    }

    /// Findings about the file with these parts: probable mistakes that are not errors.
    pub(super) fn check(&self, inline: &Inline) -> Vec<Finding> {
        let table = self.run.machine.table();
        let mut found =
            machine::check_with_ends(table, &dead_ends::ends(inline, |name| table.state(name)));
        found.extend(machine::check_events(table, &names(&inline.events)));
        found.extend(parts::noted(self.trees()));
        found
    }

    fn trees(&self) -> impl Iterator<Item = &Tree<Station>> {
        let events = self.events.iter().map(|event| &event.tree);
        let conditions = self.parts.conditions.iter().map(|(_, tree)| tree);
        self.parts.sequences.iter().chain(conditions).chain(events)
    }

    /// Resets the machine to its first state.
    pub(super) fn reset(&mut self) {
        let initial = std::mem::take(&mut self.initial);
        // It cannot fail: this machine wrote the bytes.
        let _taken = self.take(&initial).is_ok();
        self.initial = initial;
    }

    /// One decision; a final state ends the work.
    pub(super) fn tick(&mut self, world: &mut World<'_>) -> Status {
        // Events before states: a state that is left in this decision does not run its steps
        // again.
        self.run.machine.clear_trace();
        self.fire_events(world);
        let mut host = Running {
            parts: &mut self.parts,
            world,
        };
        // A fault is logged and the state kept: ending the process would drop what the arm
        // holds.
        if let Err(error) = self.run.machine.tick(&mut host) {
            let out = &mut *host.world.out;
            out.event(TraceEvent::Fault, format_args!("[fault] {error}"));
        }
        self.run.machine.status()
    }

    /// Stops everything that its states run.
    pub(super) fn stop(&mut self, world: &mut World<'_>) {
        for tree in &mut self.parts.sequences {
            parts::stop(tree, &mut self.parts.shared, world);
        }
    }

    /// The machine.
    pub(super) fn run(&self) -> &MachineRun {
        &self.run
    }

    /// Fires the trigger of the first event that has a row now. An event that fired and has
    /// held since fires again only if that leads to another state.
    fn fire_events(&mut self, world: &mut World<'_>) {
        let Self {
            run, parts, events, ..
        } = self;
        let machine = &mut run.machine;
        // All marks first, also of events after the one that fires: one that ceased must be
        // able to fire again.
        for event in events.iter_mut().filter(|event| event.has_fired) {
            event.has_fired = parts::holds(&mut event.tree, &mut parts.shared, world);
        }
        for event in events {
            let mut host = Running { parts, world };
            // Cheap checks first: a condition is evaluated only where its trigger has a row.
            if !machine.may(event.trigger, &mut host)
                || (event.has_fired && machine.stays(event.trigger, &mut host))
                || !parts::holds(&mut event.tree, &mut host.parts.shared, host.world)
            {
                continue;
            }
            event.has_fired = true;
            if let Err(error) = machine.trigger(event.trigger, &mut host) {
                let out = &mut *host.world.out;
                out.event(TraceEvent::Fault, format_args!("[fault] {error}"));
            }
            // One event per decision: a second one would be judged by a state that the first
            // has left.
            return;
        }
    }
}

/// The host of the machine during one decision.
struct Running<'p, 'w, 'x> {
    parts: &'p mut Parts,
    world: &'x mut World<'w>,
}

impl Actions for Running<'_, '_, '_> {
    fn guard(&mut self, guard: GuardId) -> bool {
        let Parts {
            conditions, shared, ..
        } = self.parts;
        let condition = conditions.get_mut(guard.index());
        condition.is_some_and(|(_, tree)| parts::holds(tree, shared, self.world))
    }

    fn call(&mut self, _callback: CallbackId, _event: &mut Event<'_>) -> Result<(), Fault> {
        Ok(())
    }

    fn run(&mut self, behavior: BehaviorId) -> Status {
        let Parts {
            sequences,
            repeats,
            shared,
            ..
        } = self.parts;
        let Some(tree) = sequences.get_mut(behavior.index()) else {
            return Status::Running;
        };
        let status = parts::tick(tree, shared, self.world);
        let repeats = repeats.get(behavior.index()) == Some(&true);
        self.world.end_refused(status == Status::Failure && repeats);
        // Without a trigger for the failure the steps start again in the next decision.
        if status == Status::Failure && repeats {
            return Status::Running;
        }
        status
    }

    fn halt(&mut self, behavior: BehaviorId, _reason: ResetReason) -> bool {
        if let Some(tree) = self.parts.sequences.get_mut(behavior.index()) {
            parts::stop(tree, &mut self.parts.shared, self.world);
        }
        true
    }
}

impl AnyPolicy for MachinePolicy {
    fn warnings(&self, cell: &Cell) -> Vec<String> {
        let mut warnings = parts::warnings(self.job.trees());
        warnings.extend(self.setup.far_picks(cell));
        warnings
    }

    fn reset(&mut self) {
        self.job.reset();
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let mut world = World::new(&setup, observation, job, out, ARM);
        world.resumed = std::mem::take(&mut self.resumed);
        let status = self.job.tick(&mut world);
        world.finish();
        world.report(status == Status::Success);
        if status == Status::Failure && world.job.failure.is_none() {
            let state = self.job.run.state();
            world.fail(state, format_args!("state '{state}' is a failure"));
        }
        self.job.run.tell(world.out);
        world.out.phase = self.phase();
    }

    fn phase(&self) -> Text<32> {
        Text::new(self.job.run.state())
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        vec![self.job.run.describe()]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        self.job.run.statuses(out);
    }

    fn save(&self) -> Vec<u8> {
        self.job.save()
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.job.restore(bytes)
    }

    /// Nothing to do: conditions and skills read the cell in every decision.
    fn reconcile(&mut self, _observation: &Observation<'_>, _job: &mut Job, _out: &mut Output) {
        self.resumed = true;
    }
}

/// The conditions that fire triggers.
fn events_of(
    parts: &[Part],
    table: &Table,
    loader: &mut Loader<'_>,
) -> Result<Vec<Condition>, SetupError> {
    let mut events = Vec::new();
    for event in parts {
        if let Some(trigger) = table.trigger(&event.name) {
            events.push(Condition {
                name: event.name.clone(),
                trigger,
                tree: loader.condition(event)?,
                has_fired: false,
            });
        }
    }
    Ok(events)
}

/// Triggers that the machine fires: its events, then the results of the steps of states.
fn triggers<'n>(events: &[&'n str], runs: &'n [DuringDef]) -> Vec<&'n str> {
    let results = runs
        .iter()
        .flat_map(|run| run.success.iter().chain(&run.failure));
    // A trigger may be named several times; it gets one id.
    let mut seen = BTreeSet::new();
    let all = events
        .iter()
        .copied()
        .chain(results.map(|name| name.text.as_str()));
    all.filter(|name| seen.insert(*name)).collect()
}

fn names(parts: &[Part]) -> Vec<&str> {
    parts.iter().map(|part| part.name.as_str()).collect()
}

fn all_states(states: &[StateDef], visit: &mut impl FnMut(&StateDef)) {
    for state in states {
        visit(state);
        all_states(&state.children, visit);
    }
}
