//! A policy whose decisions are made by a server: as any other policy of a task.

use std::sync::Arc;

use behavior::NodeStatus;
use behavior::graph::Graph;
use cell_model::Cell;
use cell_model::runs::policy_server::{PolicyServer, ServerReport};
use ipc_types::trace::TraceEvent;
use ipc_types::{Text, WorldState};
use robocell_skills::Setup;
use robocell_task::{
    AnyPolicy, Goals, Job, Observation, Outcome, Output, Remote, SetupError, checkpoint, ring,
};
use serde::{Deserialize, Serialize};

use crate::action::{self, ArmAction};
use crate::codec::{self, Convention, Rows};
use crate::failure::{Failure, reason};
use crate::kept::{self, Answer, HASH_START, Seen, Writer, hash};
use crate::link::Link;
use crate::observe::Eye;
use crate::schedule::{STEP_MS, Schedule};

/// Steps without a decision, from which on it was a pause and not a late one.
const GAP_STEPS: u64 = 10;

const PHASES: [&str; 3] = ["waiting", "following", "stale"];

/// The state that is kept from one decision to the next.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Memory {
    schedule: Schedule,
    /// The next step.
    next: u64,
    /// Index in the list of phases.
    phase: usize,
    /// By arm the action in force; empty before the first one.
    action: Vec<ArmAction>,
    /// Of all answers so far; 0 before the first.
    answers: u64,
    /// The request on its way.
    request: u64,
}

impl Memory {
    /// The last step that continues the one before; a later one follows a pause.
    fn next_after_gap(&self) -> u64 {
        match self.schedule.requests {
            0 => u64::MAX,
            _ => self.next.saturating_add(GAP_STEPS),
        }
    }
}

/// Where answers come from.
enum Source {
    Server(Link),
    Kept(Vec<Answer>),
}

/// A policy behind a socket.
pub(crate) struct RemotePolicy {
    address: String,
    server: PolicyServer,
    /// Without it the arms hold: the cell is only looked at.
    is_used: bool,
    goals: Goals,
    grip_force: f64,
    /// By arm: orientation of the tool straight down.
    down: Vec<[f64; 4]>,
    eye: Eye,
    memory: Memory,
    /// `None` before the first observation.
    source: Option<Source>,
    writer: Option<Writer>,
    seen: Arc<Seen>,
    warnings: Vec<String>,
}

impl RemotePolicy {
    pub(crate) fn new(job: Remote<'_>, seen: &Arc<Seen>) -> Result<Self, SetupError> {
        let cell = job.cell;
        let address = job.address;
        if !address.starts_with("ws://") {
            let problem = format!(
                "--policy {address}: the address of a policy server starts with ws://, as ws://127.0.0.1:8765; a server \
                 elsewhere is reached by a tunnel of ssh"
            );
            return Err(SetupError::in_file(problem));
        }
        if !has_port(address) {
            let problem =
                format!("--policy {address}: the port is missing, as in ws://127.0.0.1:8765");
            return Err(SetupError::in_file(problem));
        }
        let is_used = cell.policy_server.is_some();
        let server = cell.policy_server.clone().unwrap_or_default();
        let slots = job.goals.centres().collect();
        let eye = Eye::new(cell, &server.names, server.fault.clone(), slots);
        Ok(Self {
            address: address.to_owned(),
            eye: eye.map_err(SetupError::in_file)?,
            server,
            is_used,
            goals: job.goals,
            grip_force: job.grip_force,
            down: down(cell),
            memory: Memory::default(),
            source: None,
            writer: None,
            seen: seen.clone(),
            warnings: Vec::new(),
        })
    }

    /// A step of 50 ms begins.
    fn begin(&mut self, step: u64, state: &WorldState) -> Result<(), Failure> {
        if !self.is_used {
            return Ok(());
        }
        // After a pause the answers are about another scene.
        if step > self.memory.next_after_gap() {
            self.forget();
        }
        self.memory.next = step + 1;
        self.eye.see(state);
        if self.memory.schedule.asks(step) {
            self.ask(step, state)?;
        }
        self.take()?;
        let latency_ms = self.server.latency_ms;
        let action = self.memory.schedule.action(step, latency_ms);
        self.memory.phase = match action {
            None => 0,
            Some((_, false)) => 1,
            Some((_, true)) => 2,
        };
        if let Some(row) = action.map(|(row, _)| row.to_vec()) {
            self.memory.action = self.action_of(&row)?;
        }
        Ok(())
    }

    /// Forgets all answers, and closes the connection: an answer to an older observation may be on
    /// its way.
    fn forget(&mut self) {
        self.memory.schedule.restart();
        self.memory.action.clear();
        self.source = None;
        self.eye.clear();
    }

    fn ask(&mut self, step: u64, state: &WorldState) -> Result<(), Failure> {
        let arms = state.arms().iter().enumerate();
        let goals = arms.map(|(arm, measured)| {
            let action = self.memory.action.get(arm);
            let sent = action.and_then(ArmAction::position);
            sent.unwrap_or(measured.tcp.position)
        });
        let goals: Vec<[f64; 3]> = goals.collect();
        let observations = self.eye.observe(state, &goals);
        let bytes = codec::request(Convention::OpenPi, 0, &observations);
        let before = match self.memory.schedule.requests {
            0 => HASH_START,
            _ => self.memory.request,
        };
        self.memory.request = hash(before, bytes);
        if let Source::Server(link) = self.source()? {
            link.ask(observations);
        }
        self.memory.schedule.send(step);
        Ok(())
    }

    /// Takes the answer that is on its way, if it is there; simulated time waits for it.
    fn take(&mut self) -> Result<(), Failure> {
        if !self.memory.schedule.waits() {
            return Ok(());
        }
        let (wait, number) = (!self.server.real_time, self.memory.schedule.requests);
        let request = self.memory.request;
        let (result, is_kept) = match self.source()? {
            Source::Server(link) => match link.answer(wait) {
                Some(result) => (result, false),
                None => return Ok(()),
            },
            Source::Kept(answers) => (kept(answers, number, request), true),
        };
        // The width belongs to the cell: without this check a kept answer would be no answer.
        let result = result.and_then(|rows| self.check(rows));
        let answer = Answer::new(number, request, &result);
        let before = if self.memory.answers == 0 {
            HASH_START
        } else {
            self.memory.answers
        };
        self.memory.answers = answer.hash(before);
        if !is_kept {
            self.keep(&answer);
        }
        self.memory.schedule.answer(result?);
        Ok(())
    }

    /// Writes an answer, and compares it with earlier ones to the same observations.
    fn keep(&mut self, answer: &Answer) {
        if let Err(error) = self.write(answer) {
            let file = self.server.keep.take().unwrap_or_default();
            self.warnings.push(format!(
                "{}: the answers are not kept: {error}",
                file.display()
            ));
        }
        if !self.seen.agrees(answer) {
            self.warnings.push(format!(
                "{}: the policy server answered equal observations in two ways, in this evaluation or \
                 the kept one; its rows do not repeat",
                self.address
            ));
        }
    }

    fn write(&mut self, answer: &Answer) -> std::io::Result<()> {
        let Some(file) = &self.server.keep else {
            return Ok(());
        };
        let writer = if let Some(writer) = self.writer.take() {
            writer
        } else {
            // Answers of an earlier evaluation are compared before they are replaced.
            for answer in kept::read(file).unwrap_or_default() {
                self.seen.agrees(&answer);
            }
            Writer::open(file, self.memory.schedule.requests > 1)?
        };
        self.writer.insert(writer).add(answer)
    }

    fn source(&mut self) -> Result<&mut Source, Failure> {
        let source = match (self.source.take(), &self.server.answers) {
            (Some(source), _) => source,
            (None, Some(file)) => Source::Kept(kept::read(file)?),
            (None, None) => {
                Source::Server(Link::open(&self.address, &self.server.names, &self.seen))
            }
        };
        Ok(self.source.insert(source))
    }

    /// The actions of all arms in a row.
    fn action_of(&self, row: &[f32]) -> Result<Vec<ArmAction>, Failure> {
        action::of_row(row, &self.down).map_err(|why| {
            let message = format!("the answer of the policy server: {why}");
            Failure::new(reason::INVALID, message)
        })
    }

    /// Refuses rows that an arm cannot execute.
    fn check(&self, rows: Rows) -> Result<Rows, Failure> {
        for row in &rows {
            self.action_of(row)?;
        }
        Ok(rows)
    }
}

/// By arm: the orientation of its tool straight down.
fn down(cell: &Cell) -> Vec<[f64; 4]> {
    let arms = Setup::new(cell, []).arms;
    arms.iter().map(|arm| arm.tool.down(0.0)).collect()
}

/// Whether an address has a port.
fn has_port(address: &str) -> bool {
    let place = address.trim_start_matches("ws://").split('/').next();
    let port = place.and_then(|place| place.rsplit_once(':'));
    port.is_some_and(|(_, port)| port.parse::<u16>().is_ok())
}

/// The answer to request `number`, from 1 up.
fn kept(answers: &[Answer], number: u64, request: u64) -> Result<Rows, Failure> {
    let refused = |why: &str| {
        let message = format!(
            "request {number} {why}: the answers were kept with another build, cell or option; ask the server again"
        );
        Err(Failure::new(reason::NOT_KEPT, message))
    };
    // The last one counts: a task that was restarted may have asked again.
    match answers.iter().rev().find(|answer| answer.number == number) {
        None => refused("has no answer"),
        Some(answer) if answer.request != format!("{request:016x}") => {
            refused("has other observations")
        }
        Some(answer) => answer.clone().result(),
    }
}

impl AnyPolicy for RemotePolicy {
    fn reset(&mut self) {
        // Each episode has a connection of its own: a server may remember.
        (self.memory, self.source, self.writer) = (Memory::default(), None, None);
        self.eye.clear();
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let step = observation.sample_id() / STEP_MS;
        job.held = observation.held_object(0);
        job.placed.clear();
        self.goals.placed(observation, &mut job.placed);
        let mut done = job.done;
        let result = if step >= self.memory.next {
            // Judged at the rate of the actions, as in the environments for learning.
            done = job.placed.len() >= self.goals.count();
            self.begin(step, observation.state())
        } else {
            self.take()
        };
        job.done = done;
        match result {
            Ok(()) => {
                for (arm, action) in self.memory.action.iter().enumerate() {
                    out.arm(arm, action.intent(self.grip_force));
                }
            }
            Err(failure) => {
                // A job that is started again connects again.
                self.forget();
                job.fail(&failure.reason);
                out.event(
                    TraceEvent::Fault,
                    format_args!("[fault] {}", failure.message),
                );
            }
        }
        out.outcome = if done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        out.phase = self.phase();
    }

    fn phase(&self) -> Text<32> {
        Text::new(PHASES.get(self.memory.phase).copied().unwrap_or_default())
    }

    fn describe(&self, name: &str) -> Vec<Graph> {
        vec![ring::graph(name, &PHASES)]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        ring::statuses(&PHASES, self.phase().as_str(), out);
    }

    fn save(&self) -> Vec<u8> {
        checkpoint::to_bytes(&self.memory)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.reset();
        let memory: Memory = checkpoint::from_bytes(bytes)?;
        let arms = self.down.len();
        // Rows and actions are used without a further check.
        if memory.phase < PHASES.len() && [0, arms].contains(&memory.action.len()) {
            self.memory = memory;
            self.memory.schedule.resume();
        }
        Ok(())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, _out: &mut Output) {
        job.held = observation.held_object(0);
    }

    fn server_report(&self) -> Option<ServerReport> {
        Some(ServerReport {
            latency_ms: self.server.latency_ms,
            fault: self.server.fault.as_ref().map(ToString::to_string),
            requests: self.memory.schedule.requests,
            stale_steps: self.memory.schedule.stale_steps,
            answers: format!("{:016x}", self.memory.answers),
        })
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}
