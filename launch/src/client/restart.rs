//! `robocell restart PROC`: says when the process is back, and with what.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use cell_bus::Subscriber;
use crossterm::style::Stylize as _;
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::TraceKind;
use ipc_types::{TraceLine, WorldState};
use supervisor::control::{Request, ask};
use supervisor::failure::Failure;
use supervisor::run::policy::choose;

use super::follow::check_lives;
use super::operate::accepted;
use super::picture::Picture;
use super::session::Session;
use crate::args::{ProcessName, RestartArgs};
use crate::{say, task_program};

/// A process that was asked to restart is back within this, or something is wrong.
const PATIENCE: Duration = Duration::from_secs(20);
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(1);
/// A tick of physics (s).
const TICK_S: f64 = 1.0e-3;
/// Physics keeps its state at least this often (s): docs/limits.md.
const KEPT_WITHIN_S: f64 = 1.0;
/// The task logs how it started within this time.
const FIRST_LINE: Duration = Duration::from_millis(500);

/// Restarts a process, and waits for it.
pub(crate) fn restart(args: &RestartArgs) -> Result<(), Failure> {
    let name = args.process.word();
    let session = Session::of(&args.cell.cell)?;
    if args.process == ProcessName::Task {
        check_task(&session, args.policy.as_deref())?;
    }
    // The readers only report the result: without a free one the process is restarted as well.
    let bus = session.join().ok();
    let log = bus.as_ref().map(|bus| bus.subscriber(TopicId::Trace));
    let mut log = log.and_then(Result::ok);
    // Before the request: after it, the present start could not be told from the next one.
    let start = Start::watch(&session, args.process);
    let wish = Request::Restart {
        process: name.to_owned(),
        policy: args.policy.clone(),
    };
    let answer = accepted(ask(&session.dir.control(), &wish)?)?;
    let mut start = match start {
        Ok(start) => start,
        Err(failure) => {
            say::line(answer);
            say::warn(format_args!("its end was not waited for: {failure}"));
            return Ok(());
        }
    };
    start.wait()?;
    let after_ms = start.began.elapsed().as_millis();
    let details = match args.process {
        ProcessName::Task => task_details(&session, &start.picture, log.as_mut())?,
        ProcessName::Physics => start.resumption()?,
        ProcessName::Controller | ProcessName::Monitor => String::new(),
    };
    say::line(format_args!("{name} is back after {after_ms} ms{details}"));
    Ok(())
}

/// How far physics went back, from `last_tick` to `resumed_tick`.
fn resumption(last_tick: u64, resumed_tick: u64) -> String {
    let seconds = |ticks: u64| ticks as f64 * TICK_S;
    let back_s = seconds(last_tick.saturating_sub(resumed_tick));
    let text = format!(
        "resumed {back_s:.1} s back at {:.3} s",
        seconds(resumed_tick)
    );
    let is_far = back_s > KEPT_WITHIN_S && std::io::stdout().is_terminal();
    let text = if is_far { text.red().to_string() } else { text };
    format!(", {text}")
}

/// The next start of all processes of a name.
struct Start<'a> {
    session: &'a Session,
    name: ProcessName,
    picture: Picture,
    /// Which start each of the processes is, before.
    before: Vec<(Process, u32)>,
    /// Which start of physics the last state is of, and its tick.
    last: (u32, u64),
    began: Instant,
}

impl<'a> Start<'a> {
    fn watch(session: &'a Session, name: ProcessName) -> Result<Self, Failure> {
        let mut picture = Picture::open(session)?;
        // Without the first health messages, a later one of the old process would pass for a new
        // start.
        picture.fill();
        let named = picture
            .starts()
            .filter(|(process, _)| name.includes(*process));
        let last = picture.state().map(|state| &state.header);
        Ok(Self {
            session,
            name,
            before: named.collect(),
            last: last.map_or((0, 0), |header| (header.generation, header.tick)),
            began: Instant::now(),
            picture,
        })
    }

    /// Looks until `seen`.
    fn until<T>(&mut self, seen: impl Fn(&Self) -> Option<T>) -> Result<T, Failure> {
        loop {
            self.picture.update();
            if let Some(found) = seen(self) {
                return Ok(found);
            }
            check_lives(self.session)?;
            if self.began.elapsed() > PATIENCE {
                let name = self.name.word();
                return Err(Failure::configuration(format!(
                    "{name} was asked to restart and is not back after {} s; \
                     `robocell logs {name}` says more",
                    PATIENCE.as_secs()
                )));
            }
            let header = self.picture.state().map(|state| &state.header);
            // The old physics continues until it is ended: its last tick counts, not that of the
            // request.
            if let Some(header) = header.filter(|header| header.generation == self.last.0) {
                self.last.1 = header.tick;
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Waits until all have started again.
    fn wait(&mut self) -> Result<(), Failure> {
        self.until(|start| {
            let now = || start.picture.starts();
            let is_new = |(process, before): &(Process, u32)| {
                now().any(|(of, number)| of == *process && number > *before)
            };
            start.before.iter().all(is_new).then_some(())
        })
    }

    /// How far back the new physics continues.
    fn resumption(&mut self) -> Result<String, Failure> {
        let resumed_tick = self.until(|start| {
            let state = start.picture.state()?;
            (state.header.generation > start.last.0).then_some(state.resumed_tick)
        })?;
        Ok(resumption(self.last.1, resumed_tick))
    }
}

/// Objects still held, and how the task started.
fn task_details(
    session: &Session,
    picture: &Picture,
    log: Option<&mut Subscriber<TraceLine>>,
) -> Result<String, Failure> {
    let cell = session.load_cell()?;
    let arms = picture.state().map_or(&[][..], WorldState::arms);
    let held = arms.iter().filter_map(|arm| {
        let index = (arm.gripper.held_object as usize).checked_sub(1)?;
        cell.objects.get(index)
    });
    let mut details = Vec::new();
    details.extend(held.map(|object| format!(", {} still held", object.name)));
    details.extend(log.and_then(first_line).map(|line| format!(", {line}")));
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
