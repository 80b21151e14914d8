//! The invariants of a cell. Their numbers are those of the promises (docs/faults.md), not the
//! constants of the code: a change of a constant must not move both.

mod grip;
mod history;
mod hold;
mod kept;
mod limits;
mod people;
mod progress;
mod reports;
mod script;
mod supervision;
mod wakes;
mod writers;

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_ENDING;
use ipc_types::{ArmCommand, ArmStatus, Decision, Health, OperatorReply, TraceLine, WorldState};
use ipc_types::{Header, Wire};

use crate::coverage::Coverage;
use crate::model::{Model, News};
use crate::plan::{Asked, Fault, MS, Plan, noise};

/// Events that are kept for people.
const LOG: usize = 200;

/// Something that can be seen.
#[derive(Clone, Copy, Debug)]
pub enum Seen<'a> {
    /// A state.
    State(&'a WorldState),
    /// A decision.
    Decision(&'a Decision),
    /// A status of an arm.
    Status(usize, &'a ArmStatus),
    /// A command to an arm.
    Command(usize, &'a ArmCommand),
    /// A line of the task.
    Trace(&'a TraceLine),
    /// A sign of life.
    Health(Process, &'a Health),
    /// What a reader used of a topic on which messages are disturbed.
    Used(TopicId, &'a Header),
    /// A process started, ended, or said something.
    News(&'a News),
    /// A fault that had an effect.
    Fault(&'a Fault),
    /// A person sent a request.
    Asked(&'a Asked),
    /// Physics answered it.
    Answered(&'a Asked, &'a OperatorReply),
    /// The launcher has looked.
    Looked,
    /// The launcher gave the run up.
    GaveUp(&'a str),
}

/// Something that is seen, and when.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// Virtual time (ns).
    pub now_ns: u64,
    /// What.
    pub seen: Seen<'a>,
}

/// Whether an invariant holds: the error says why not.
pub type Verdict = Result<(), String>;

/// An invariant.
pub trait Check {
    /// Its number in docs/simulation.md.
    fn number(&self) -> u32;

    /// Takes note of a moment.
    fn see(&mut self, moment: &Moment<'_>) -> Verdict;

    /// The run is over.
    fn end(&mut self, _now_ns: u64) -> Verdict {
        Ok(())
    }
}

/// An invariant that did not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failed {
    /// Its number.
    pub invariant: u32,
    /// When (us).
    pub at_us: u64,
    /// Why.
    pub why: String,
}

/// All invariants of a run, and what they saw.
pub struct Checks {
    all: Vec<Box<dyn Check>>,
    digest: u64,
    tick: u64,
    ticks: u64,
    keeps_decisions: bool,
    coverage: Coverage,
    log: Vec<String>,
    /// State hashes at every hundredth tick.
    hashes: Vec<(u64, u64)>,
    /// Hashes of what decisions say, by tick.
    decisions: BTreeMap<u64, u64>,
}

/// Fails with `why` if `fails`.
fn fail_if(fails: bool, why: impl FnOnce() -> String) -> Verdict {
    if fails { Err(why()) } else { Ok(()) }
}

impl Checks {
    /// Of a run of `plan` in `model`.
    pub fn of(plan: &Plan, model: &Model) -> Self {
        let mut all = hold::all(plan);
        all.extend(grip::all(plan));
        all.extend(people::all(plan));
        all.extend(limits::all(model));
        all.extend(writers::all(plan));
        all.extend(kept::all());
        all.extend(supervision::all(plan, model));
        all.extend(reports::all(plan));
        all.extend(progress::all(plan));
        all.extend(script::all(plan, model));
        all.extend(wakes::all(plan));
        Self {
            all,
            digest: 0,
            tick: 0,
            ticks: 0,
            // For the comparison with the run without faults.
            keeps_decisions: plan.lockstep,
            coverage: Coverage::default(),
            log: Vec::new(),
            hashes: Vec::new(),
            decisions: BTreeMap::new(),
        }
    }

    /// Shows `moment` to every invariant; returns the first that does not hold.
    pub fn see(&mut self, moment: &Moment<'_>) -> Option<Failed> {
        self.record(moment);
        self.coverage.see(moment);
        self.first(moment.now_ns, |check| check.see(moment))
    }

    /// The run is over.
    pub fn end(&mut self, now_ns: u64) -> Option<Failed> {
        self.first(now_ns, |check| check.end(now_ns))
    }

    fn first(
        &mut self,
        now_ns: u64,
        mut ask: impl FnMut(&mut dyn Check) -> Verdict,
    ) -> Option<Failed> {
        self.all.iter_mut().find_map(|check| {
            let why = ask(check.as_mut()).err()?;
            Some(Failed {
                invariant: check.number(),
                at_us: now_ns / 1000,
                why,
            })
        })
    }

    /// Hash over all that was seen.
    pub fn result(&self) -> u64 {
        self.digest
    }

    /// The states that were reached.
    pub fn take_coverage(&mut self) -> Coverage {
        std::mem::take(&mut self.coverage)
    }

    /// Ticks of physics, those that a restart repeats included.
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// The last events.
    pub fn take_log(&mut self) -> Vec<String> {
        std::mem::take(&mut self.log)
    }

    /// State hashes at every hundredth tick, by the last physics that came by it.
    pub fn hashes(&self) -> &[(u64, u64)] {
        &self.hashes
    }

    /// Hashes of what decisions say, by tick.
    pub fn decisions(&self) -> &BTreeMap<u64, u64> {
        &self.decisions
    }

    fn record(&mut self, moment: &Moment<'_>) {
        let header = match moment.seen {
            Seen::State(state) => {
                let tick = state.header.tick;
                self.ticks += u64::from(std::mem::replace(&mut self.tick, tick) != tick);
                self.digest(state.state_hash);
                if tick.is_multiple_of(100) || state.has(FLAG_ENDING) {
                    self.hashes.retain(|(other, _)| *other < tick);
                    self.hashes.push((tick, state.state_hash));
                }
                state.header
            }
            Seen::Decision(message) => {
                if self.keeps_decisions {
                    self.decisions.insert(message.header.tick, said(message));
                }
                message.header
            }
            Seen::Status(_, message) => message.header,
            Seen::Command(_, message) => message.header,
            Seen::Trace(line) => {
                let text = format!("task: {}", line.text.as_str());
                return self.note(moment.now_ns, &text);
            }
            Seen::Health(_, message) => message.header,
            Seen::News(news) => return self.note(moment.now_ns, &format!("{news:?}")),
            Seen::Fault(fault) => return self.note(moment.now_ns, &format!("{fault:?}")),
            Seen::Answered(asked, reply) => {
                let text = format!("{asked:?}: {}, tick {}", reply.code, reply.header.tick);
                return self.note(moment.now_ns, &text);
            }
            Seen::GaveUp(why) => return self.note(moment.now_ns, &format!("given up: {why}")),
            Seen::Asked(_) | Seen::Looked | Seen::Used(..) => return,
        };
        for value in [moment.now_ns, u64::from(header.generation), header.seq] {
            self.digest(value);
        }
    }

    fn digest(&mut self, value: u64) {
        self.digest = noise(self.digest, value, 0);
    }

    fn note(&mut self, now_ns: u64, text: &str) {
        let mut hasher = DefaultHasher::new();
        (now_ns, text).hash(&mut hasher);
        self.digest(hasher.finish());
        if self.log.len() == LOG {
            self.log.remove(0);
        }
        let at_s = now_ns as f64 * 1.0e-9;
        self.log.push(format!("{at_s:.6} s: {text}"));
    }
}

/// Hash of a decision without its header, which names its writer.
fn said(decision: &Decision) -> u64 {
    let mut decision = *decision;
    decision.header = Header::zeroed();
    let mut hasher = DefaultHasher::new();
    decision.as_bytes().hash(&mut hasher);
    hasher.finish()
}

/// Milliseconds of `ns`.
fn ms(ns: u64) -> u64 {
    ns / MS
}
