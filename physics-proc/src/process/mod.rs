//! Physics on the bus: take the newest inputs, step, publish the state.
//!
//! All other processes follow the ticks of this one, so these rules hold:
//!
//! - In real time physics waits for no process. A controller that is late or dead is handled
//!   by the watchdog of its arm; a wait here would stop the whole cell.
//! - In lockstep it waits for the answer to exactly the tick that it published (ADR 0004). It
//!   answers requests during the wait, and repeats its doorbells: a lost one would stop the
//!   run.
//! - Inputs that answer another generation of physics are ignored: they belong to a scene that
//!   a kill has discarded.
//! - A state is announced before it is published and written after it, by another thread. The
//!   task keeps its checkpoint for an announced state; the other order would lose it.
//! - Files are written by threads of their own, without real-time scheduling: a write takes
//!   longer than a tick.

use cell_bus::{Bus, BusError, Doorbell, Latest, OperatorServer, Publisher};
use cell_model::stop::DECISION_AGE_OTHER_TICKS;
use cell_rt::priority::PHYSICS_PRIORITY;
use cell_rt::{Clock, Grid, Monotonic};
use cell_run::spec::Speed;
use cell_worker::{HealthReporter, LoopClass, RunError, Start, Turn, Wait, Woken};
use ipc_types::contact::CONTACT_TICKS;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{
    ArmCommand, Contacts, DECISION_TICKS, Decision, Header, MAX_ARMS, TICK_NS, WorldState,
};

use crate::plant::{Next, Plant};
use crate::recorder_pace::RecorderPace;
use crate::resume::{Resume, Store};
use crate::script_report::ScriptReport;
use crate::state::lost::LostNews;
use crate::state::tap::StateTap;
use crate::world::StepInput;

mod lockstep;
mod model;

use lockstep::{Answers, paced_period_ns};
pub use model::model;

/// Publication times kept for the age of applied commands.
// Older commands than this are not measured: they are past the age at which the arm brakes.
const PUBLISHED: usize = 64;
/// Requests answered in one tick.
// Bounds a tick: the requests beyond it are answered in the next one.
const REQUESTS_PER_TICK: usize = 8;

/// Why physics cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The scene.
    #[error(transparent)]
    World(#[from] crate::world::WorldError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

impl RunError for ProcessError {
    fn is_lasting(&self) -> bool {
        match self {
            Self::World(_) => true,
            Self::Bus(error) => error.is_lasting(),
        }
    }
}

/// Runs physics until it is asked to stop.
///
/// # Errors
///
/// When the scene cannot be set up or the bus cannot be joined. Everything that
/// can fail happens before the bus is touched.
pub fn run(start: &Start) -> Result<(), ProcessError> {
    let mut plant = Plant::new(&start.cell, &start.spec)?;
    for warning in crate::warnings(&start.cell) {
        cell_worker::warn(format_args!("{warning}"));
    }
    let was_one = start.generation > 1;
    let (run_dir, run) = (&start.spec.run_dir, start.spec.run);
    // Opened before this thread gets real-time scheduling and a core for itself: the threads
    // that write files inherit both from the thread that starts them.
    let resume = Resume::open(run_dir, run, was_one, &mut plant);
    let report = ScriptReport::new(run_dir);
    let fifo = start.real_time(PHYSICS_PRIORITY, 0);
    let bus = start.join(Process::Physics)?;
    let mut bell = bus.sleeper(Process::Physics)?;
    let mut process = PhysicsProcess::new(start, &bus, (plant, resume, report), fifo, Monotonic)?;
    // Pages are touched before the loop starts, so that no tick waits for a page fault.
    start.populate();
    cell_worker::run(&mut process, &mut bell);
    Ok(())
}

struct PhysicsProcess<C, S> {
    plant: Plant,
    resume: Resume<S>,
    report: ScriptReport,
    generation: u32,
    tick: u64,
    state: Publisher<WorldState>,
    tap: StateTap,
    contacts: Publisher<Contacts>,
    commands: Vec<Latest<ArmCommand>>,
    decision: Latest<Decision>,
    recorder: RecorderPace,
    operator: OperatorServer,
    health: HealthReporter,
    controller_bells: Vec<Doorbell>,
    task_bell: Doorbell,
    monitor_bell: Doorbell,
    clock: C,
    class: LoopClass,
    fifo: bool,
    /// Deadlines of the present speed.
    grid: Grid,
    awaits: Await,
    /// Speed that the loop follows; `None` before the first tick.
    speed: Option<Speed>,
    contacts_tick: Option<u64>,
    published_ns: [u64; PUBLISHED],
    overruns: u64,
    /// Those before the present speed.
    overruns_before: u64,
    /// Number of faulty arms.
    faults: usize,
    /// Objects that fell out of the cell.
    lost: LostNews,
    /// Values of a tick that the black box keeps for an incident.
    boxed: [f64; 4],
}

/// The event for which the loop waits.
#[derive(Clone, Copy)]
enum Await {
    /// Nothing: this is the first turn.
    Start,
    /// In real time the next tick.
    Deadline,
    /// In lockstep the answers to the present tick.
    Answers(Answers),
    /// In lockstep slower than the processes the next tick; the wait began at this time.
    Pace(u64),
    /// In lockstep, while paused, a request.
    Request(u64),
}

impl<C: Clock, S: Store> Turn for PhysicsProcess<C, S> {
    fn turn(&mut self, woken: Woken) -> Wait {
        match self.awaits {
            Await::Start => self.next(),
            Await::Deadline => self.real_time(woken.now_ns),
            Await::Answers(answers) => self.answers(answers, woken),
            Await::Pace(began_ns) => {
                self.grid.woke(woken.now_ns);
                self.lockstep(began_ns)
            }
            Await::Request(began_ns) => {
                self.health.idle();
                self.finish_lockstep(began_ns, Next::Wait)
            }
        }
    }
}

impl<C: Clock, S: Store> PhysicsProcess<C, S> {
    fn new(
        start: &Start,
        bus: &Bus,
        (mut plant, resume, report): (Plant, Resume<S>, ScriptReport),
        fifo: bool,
        clock: C,
    ) -> Result<Self, BusError> {
        // Without real-time scheduling the task is late more often; the belt must not stop for
        // it.
        if !fifo {
            plant.set_decision_limit(DECISION_AGE_OTHER_TICKS);
        }
        let spec = &start.spec;
        let commands = (0..spec.arms).map(|arm| bus.latest(TopicId::ArmCommand(arm)));
        let bells = (0..spec.arms).map(|arm| bus.doorbell(Process::Controller(arm)));
        Ok(Self {
            tick: plant.world().tick(),
            lost: LostNews::new(plant.world()),
            plant,
            resume,
            report,
            // All ports are opened here: a port that fails ends the process before the first
            // tick.
            generation: bus.generation(),
            state: bus.publisher(TopicId::WorldState)?,
            tap: StateTap::new(bus)?,
            contacts: bus.publisher(TopicId::Contacts)?,
            commands: commands.collect::<Result<_, _>>()?,
            decision: bus.latest(TopicId::Decision)?,
            recorder: RecorderPace::new(bus, spec.record.file.is_some())?,
            operator: bus.operator_server()?,
            health: HealthReporter::new(start, bus, Process::Physics, fifo, clock.now_ns())?,
            controller_bells: bells.collect::<Result<_, _>>()?,
            task_bell: bus.doorbell(Process::Task)?,
            monitor_bell: bus.doorbell(Process::Monitor)?,
            class: LoopClass::new(start, PHYSICS_PRIORITY, fifo),
            fifo,
            grid: Grid::new(TICK_NS, clock.now_ns(), fifo),
            clock,
            awaits: Await::Start,
            speed: None,
            contacts_tick: None,
            published_ns: [0; PUBLISHED],
            overruns: 0,
            overruns_before: 0,
            faults: 0,
            boxed: [0.0; 4],
        })
    }

    /// How to wait for the next tick at the speed that was asked for last.
    fn next(&mut self) -> Wait {
        let speed = self.plant.speed();
        if self.speed != Some(speed) {
            self.follow(speed);
        }
        let now_ns = self.clock.now_ns();
        if speed.is_lockstep() {
            self.awaits = Await::Answers(Answers::since(now_ns));
            return Wait::Spin;
        }
        self.awaits = Await::Deadline;
        Wait::next_of(&mut self.grid, now_ns)
    }

    /// Starts the grid of another speed.
    fn follow(&mut self, speed: Speed) {
        self.speed = Some(speed);
        self.class.follow(speed.is_lockstep());
        self.health.set_lockstep(speed.is_lockstep());
        let (period_ns, fifo) = match speed {
            Speed::RealTime => (TICK_NS, self.fifo),
            Speed::Max => (1, false),
            Speed::Factor(factor) => (paced_period_ns(factor).max(1), false),
        };
        self.grid = Grid::new(period_ns, self.clock.now_ns(), fifo);
        self.overruns_before = self.overruns;
        // Other processes wait for the resumed state. An announced state has to be saved.
        self.publish();
        self.keep();
    }

    /// One tick each millisecond on an absolute grid; physics waits for no process.
    fn real_time(&mut self, woke_ns: u64) -> Wait {
        let wake = self.grid.woke(woke_ns);
        self.overruns = self.overruns_before + self.grid.overruns();
        // Inputs are taken after the wait: the newest command is at most as old as the
        // answer to the last state.
        self.take_inputs();
        self.step();
        self.publish();
        // After the state is published: files and logs must not delay the controllers.
        self.keep();
        let now_ns = self.clock.now_ns();
        let late_ns = wake.lateness_ns();
        self.health
            .cycle(self.tick, woke_ns, late_ns, self.boxed, now_ns);
        self.health.publish_if_due(self.tick, now_ns);
        self.next()
    }

    /// Takes new messages; [`Self::step`] ignores those that another generation of physics
    /// caused. True when a request was answered.
    fn take_inputs(&mut self) -> bool {
        for command in &mut self.commands {
            command.refresh();
        }
        self.decision.refresh();
        let plant = &mut self.plant;
        let resume = &mut self.resume;
        self.operator.poll(REQUESTS_PER_TICK, |request| {
            let reply = plant.answer_request(request);
            resume.note(plant, request, &reply);
            reply
        }) > 0
    }

    fn step(&mut self) -> Next {
        let generation = self.generation;
        // A message that answers a killed physics is about a scene that may not exist here.
        let mine = |header: &Header| header.answers(generation);
        let decision = self.decision.get().filter(|d| mine(&d.header));
        let next = self.plant.before_step(decision);
        if next == Next::Step {
            let mut commands = [None; MAX_ARMS];
            for (slot, command) in commands.iter_mut().zip(&self.commands) {
                *slot = command.get().filter(|c| mine(&c.header));
            }
            for command in commands.iter().flatten() {
                let age = self.tick.saturating_sub(command.header.tick);
                let published_ns = self.published_ns[index(command.header.tick)];
                // The ring holds the last ticks only: an older slot has the time of another
                // tick.
                if age < PUBLISHED as u64 {
                    self.health
                        .applied(self.clock.now_ns().saturating_sub(published_ns));
                }
            }
            self.plant.step(&StepInput { commands, decision });
        }
        next
    }

    /// Saves the state, and reports faults and lost objects once each.
    fn keep(&mut self) {
        let faults = self.plant.world().faults();
        // Reported when the number grows: a fault lasts until a reset and would fill the log.
        if std::mem::replace(&mut self.faults, faults) < faults {
            cell_worker::warn(format_args!("{}", self.plant.world().fault_words()));
        }
        self.lost.report(self.plant.world());
        self.resume.save(&self.plant);
        let mut lost = self.resume.lost(self.tick);
        if lost.is_empty() {
            lost.push_str(&self.lost.words);
        }
        self.health
            .fault((!lost.is_empty()).then_some(lost.as_str()));
        self.report.send_new(&self.plant);
    }

    fn publish(&mut self) {
        let (plant, overruns, tap) = (&self.plant, self.overruns, &mut self.tap);
        let (saving_tick, saved_tick) = self.resume.announce(plant);
        let boxed = &mut self.boxed;
        // A state that was not sent is followed by the next one; the port counts it.
        let _sent = self.state.publish(|state| {
            plant.write_state(state);
            state.overruns = overruns;
            state.saving_tick = saving_tick;
            state.saved_tick = saved_tick;
            *boxed = boxed_values(state);
            // Copied while the message is written: the loan of shared memory ends with this
            // closure.
            tap.keep(state);
        });
        self.tick = self.plant.world().tick();
        self.published_ns[index(self.tick)] = self.clock.now_ns();
        let counts = self.commands.iter().map(|c| c.subscriber().counts());
        let (rejected, fenced) = counts
            .chain([self.decision.subscriber().counts()])
            .fold((0, 0), |(r, f), c| (r + c.rejected, f + c.fenced));
        self.health.totals(self.overruns, rejected, fenced);
        let now_ns = self.published_ns[index(self.tick)];
        for command in &mut self.commands {
            self.health
                .refused("command", command.take_invalid(), now_ns);
        }
        let invalid = self.decision.take_invalid();
        self.health.refused("decision", invalid, now_ns);
        // Doorbells first, then copies for recorder and people: their cost must not delay
        // control.
        self.ring();
        self.tap.publish(self.state.header());
        self.publish_contacts();
    }

    /// For people, after all controlling processes have the state.
    fn publish_contacts(&mut self) {
        // Once per tick also while paused, when the same tick is published again.
        if self.tick.is_multiple_of(CONTACT_TICKS) && self.contacts_tick != Some(self.tick) {
            self.contacts_tick = Some(self.tick);
            let world = self.plant.world();
            // The next message replaces one that was not sent.
            let _sent = self.contacts.publish(|out| world.write_contacts(out));
        }
    }

    fn ring(&mut self) {
        self.controller_bells.iter_mut().for_each(Doorbell::ring);
        // The task decides on these ticks only; a doorbell in each tick would wake it for
        // nothing.
        if self.tick.is_multiple_of(DECISION_TICKS) {
            self.task_bell.ring();
            self.monitor_bell.ring();
        }
    }
}

/// Stop action and speed of the fastest joint, for each arm.
fn boxed_values(state: &WorldState) -> [f64; 4] {
    let [first, second] = state.arms.each_ref().map(|arm| {
        let speeds = arm.joint_velocities.iter();
        let top = speeds.fold(0.0, |top: f64, speed| top.max(speed.abs()));
        [f64::from(arm.stop_action), top]
    });
    [first[0], first[1], second[0], second[1]]
}

fn index(tick: u64) -> usize {
    usize::try_from(tick % PUBLISHED as u64).unwrap_or(0)
}
