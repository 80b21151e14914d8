//! `robocell restart PROC`: says when the process is back, and with what.

use std::time::{Duration, Instant};

use cell_bus::{Bus, Latest, Subscriber};
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::TraceKind;
use ipc_types::{Health, TraceLine};
use supervisor::control::{Request, ask};
use supervisor::failure::{Context, Failure};
use supervisor::run::policy::choose;

use super::Session;
use super::follow::{Follower, check_lives};
use super::operate::accepted;
use crate::cli::{ProcessName, RestartArgs};
use crate::{say, task_program};

/// A process that was asked to restart is back within this, or something is wrong.
const PATIENCE: Duration = Duration::from_secs(20);
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(1);
/// The line of the log that says how the task began comes within this.
const FIRST_LINE: Duration = Duration::from_millis(500);

/// Restarts a process, and waits for it.
pub(crate) fn restart(args: &RestartArgs) -> Result<(), Failure> {
    let name = match args.process {
        ProcessName::Task => "task",
        ProcessName::Controller => "controller",
        ProcessName::Physics => "physics",
        ProcessName::Monitor => "monitor",
    };
    let session = Session::of(&args.cell.cell)?;
    if args.process == ProcessName::Task {
        check_task(&session, args.policy.as_deref())?;
    }
    let bus = session.join()?;
    let is_named = |process: &Process| args.process.includes(*process);
    let processes = Process::all(session.spec.arms).into_iter().filter(is_named);
    let mut starts = processes
        .map(|process| Start::watch(&bus, process))
        .collect::<Result<Vec<_>, _>>()?;
    let mut log = bus
        .subscriber(TopicId::Trace)
        .cannot("read the task's log")?;
    let began = Instant::now();
    let wish = Request::Restart {
        process: name.to_owned(),
        policy: args.policy.clone(),
    };
    accepted(ask(&session.dir.control(), &wish)?)?;
    for start in &mut starts {
        start.wait(&session, began)?;
    }
    let after_ms = began.elapsed().as_millis();
    let details = match args.process {
        ProcessName::Task => task_details(&session, &bus, &mut log)?,
        ProcessName::Physics => {
            let state = Follower::new(&session, &bus)?.now()?;
            format!(", at {:.3} s", state.header.sim_time_ns as f64 * 1.0e-9)
        }
        ProcessName::Controller | ProcessName::Monitor => String::new(),
    };
    say::line(format_args!("{name} is back after {after_ms} ms{details}"));
    Ok(())
}

/// The starts of one process.
struct Start {
    process: Process,
    health: Latest<Health>,
    before: u32,
}

impl Start {
    fn watch(bus: &Bus, process: Process) -> Result<Self, Failure> {
        let topic = TopicId::Health(process);
        let mut health: Latest<Health> = bus.latest(topic).cannot("read the health")?;
        health.refresh();
        let before = health.get().map_or(0, |health| health.header.generation);
        Ok(Self {
            process,
            health,
            before,
        })
    }

    /// Waits for the next start.
    fn wait(&mut self, session: &Session, began: Instant) -> Result<(), Failure> {
        loop {
            self.health.refresh();
            let health = self.health.get();
            if health.is_some_and(|health| health.header.generation > self.before) {
                return Ok(());
            }
            check_lives(session)?;
            if began.elapsed() > PATIENCE {
                let name = self.process.name();
                return Err(Failure::configuration(format!(
                    "{name} was asked to restart and is not back after {} s; \
                     `robocell logs {name}` says more",
                    PATIENCE.as_secs()
                )));
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// What is held, and how the task began.
fn task_details(
    session: &Session,
    bus: &Bus,
    log: &mut Subscriber<TraceLine>,
) -> Result<String, Failure> {
    let state = Follower::new(session, bus)?.now()?;
    let cell = session.load_cell()?;
    let held = state.arms().iter().filter_map(|arm| {
        let index = (arm.gripper.held_object as usize).checked_sub(1)?;
        cell.objects.get(index)
    });
    let mut details = Vec::new();
    details.extend(held.map(|object| format!(", {} still held", object.name)));
    details.extend(first_line(log).map(|line| format!(", {line}")));
    Ok(details.concat())
}

/// The task's line about its own start.
fn first_line(log: &mut Subscriber<TraceLine>) -> Option<String> {
    let until = Instant::now() + FIRST_LINE;
    let mut found = None;
    while found.is_none() && Instant::now() < until {
        log.take_all(|line| {
            if found.is_none() && TraceKind::from_code(line.kind) == Some(TraceKind::Lifecycle) {
                let text = line.text.as_str();
                found = Some(text.strip_prefix("[task] ").unwrap_or(text).to_owned());
            }
        });
        std::thread::sleep(LOOK);
    }
    found
}

/// Nothing that runs is stopped for a task that would not start.
fn check_task(session: &Session, policy: Option<&str>) -> Result<(), Failure> {
    let spec = &session.spec;
    let data = spec.data_dir.as_deref();
    let kept = |failure: Failure| Failure {
        message: format!("{}\nthe task that runs was left alone", failure.message),
        ..failure
    };
    let cell = session.load_cell().map_err(kept)?;
    let policy = choose(policy, &cell.policies, &spec.policy, &spec.demo)?;
    let program = spec.task_program.as_deref();
    task_program::check_policy(
        program,
        &spec.demo,
        &policy,
        (data, &spec.set, &spec.replace),
    )
    .map(drop)
    .map_err(kept)
}
