//! What went wrong is said once, and nothing is said of a run in which nothing did.

use std::collections::{BTreeMap, BTreeSet};

use ipc_types::decision::Outcome;
use ipc_types::topic::Process;
use supervisor::supervision::Exit;

use super::{Check, Moment, Seen, Verdict, fail_if, ms};
use crate::model::{News, Signal};
use crate::plan::{MS, Plan};

/// A death is told within this (ms).
const TOLD_MS: u64 = 100;
/// Starvation is told at most once in this (ms).
const STARVED_MS: u64 = 60_000;

pub(super) fn all(plan: &Plan) -> Vec<Box<dyn Check>> {
    let starved = Starved::default();
    let mut all: Vec<Box<dyn Check>> = vec![
        Box::new(Deaths::default()),
        Box::new(starved),
        Box::new(Damaged::default()),
        Box::new(Reasons),
    ];
    if plan.faults.is_empty() && plan.script.is_empty() {
        all.push(Box::new(Calm));
    }
    all
}

/// Nothing is wrong, so nothing is said, but of objects that fall off a table.
struct Calm;

impl Check for Calm {
    fn number(&self) -> u32 {
        29
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let said = match moment.seen {
            Seen::News(News::Warned(text) | News::Logged(_, text)) => text,
            Seen::Health(_, health) => match health.fault() {
                Some(fault) => fault,
                None => return Ok(()),
            },
            _ => return Ok(()),
        };
        fail_if(!said.contains("out of the cell"), || {
            format!("without a fault it was said: {said}")
        })
    }
}

/// A job that failed says why.
struct Reasons;

impl Check for Reasons {
    fn number(&self) -> u32 {
        30
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::Decision(decision) = moment.seen else {
            return Ok(());
        };
        let has_failed = decision.outcome == Outcome::Failed.code();
        fail_if(has_failed && decision.reason.as_str().is_empty(), || {
            format!(
                "the job failed without a reason at tick {}",
                decision.header.tick
            )
        })
    }
}

/// A process that starts on a damaged file says so, and says it of no other.
#[derive(Default)]
struct Damaged {
    /// By process: the file, and when it started on it (ns).
    met: BTreeMap<Process, (&'static str, u64)>,
    /// Those that said so, and those that have a reason to: the damage stays until it is written
    /// over.
    said: BTreeSet<Process>,
    may_say: BTreeSet<Process>,
}

impl Check for Damaged {
    fn number(&self) -> u32 {
        29
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::News(News::Meets(process, file, _)) => {
                self.said.remove(process);
                self.may_say.insert(*process);
                self.met.insert(*process, (*file, moment.now_ns));
            }
            Seen::News(News::Gone(process, ..)) => {
                self.met.remove(process);
            }
            Seen::News(News::Logged(process, line)) => {
                if line.contains("lost: ") {
                    self.said.insert(*process);
                }
                return fail_if(
                    line.contains("damaged") && !self.may_say.contains(process),
                    || format!("{} said: {line}", process.name()),
                );
            }
            Seen::Looked => {
                let silent = |(of, (_, at_ns)): &(&Process, &(&str, u64))| {
                    !self.said.contains(of) && moment.now_ns > at_ns + TOLD_MS * MS
                };
                if let Some((process, (file, _))) = self.met.iter().find(silent) {
                    let name = process.name();
                    return Err(format!("{name} started on a damaged {file} and is silent"));
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// A process that lacks a core is reported once, however long that lasts.
#[derive(Default)]
struct Starved {
    /// By process: when it was reported last (ns).
    told: BTreeMap<String, u64>,
}

impl Check for Starved {
    fn number(&self) -> u32 {
        29
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::News(News::Warned(text)) = moment.seen else {
            return Ok(());
        };
        let Some((process, _)) = text.split_once(" gets too little processor time") else {
            return Ok(());
        };
        let before_ns = self.told.insert(process.to_owned(), moment.now_ns);
        let again = before_ns.is_some_and(|before| moment.now_ns < before + STARVED_MS * MS);
        fail_if(again, || {
            format!("{process} was reported as starving twice in a minute")
        })
    }
}

/// Each death that was not asked for is told once, with the name of the process.
#[derive(Default)]
struct Deaths {
    /// By process: deaths that were not told, and when the last was.
    untold: BTreeMap<Process, (u32, u64)>,
    /// Those that the launcher ended itself.
    asked: Vec<Process>,
    /// The launcher gave the monitor up: it does not report each further attempt.
    has_no_monitor: bool,
    gave_up: bool,
}

impl Check for Deaths {
    fn number(&self) -> u32 {
        29
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::News(News::Signalled(process, Signal::Terminate | Signal::Kill)) => {
                self.asked.push(*process);
            }
            Seen::News(News::Gone(process, _, exit)) => {
                let was_asked = self.asked.contains(process);
                self.asked.retain(|asked| asked != process);
                let is_try = *process == Process::Monitor && self.has_no_monitor;
                if !was_asked && !is_try && *exit != Exit::Code(0) {
                    let of = self.untold.entry(*process).or_default();
                    *of = (of.0 + 1, moment.now_ns);
                }
            }
            Seen::News(News::Began(Process::Monitor, _)) => self.has_no_monitor = false,
            Seen::News(News::Warned(text)) => {
                self.has_no_monitor |= text.starts_with("monitor has stopped");
                let of = self.untold.iter_mut();
                let mut of = of.filter(|(process, _)| text.starts_with(&process.name()));
                if let Some((_, (count, _))) = of.next() {
                    *count = count.saturating_sub(1);
                }
            }
            Seen::GaveUp(_) => self.gave_up = true,
            // Then everything ends, and nobody is told of each.
            Seen::Looked if !self.gave_up => {
                // The launcher looks every 5 ms, unless it is not scheduled.
                let late = |(_, (count, at_ns)): &(&Process, &(u32, u64))| {
                    *count > 0 && moment.now_ns > at_ns + TOLD_MS * MS
                };
                let late = self.untold.iter().find(late);
                return late.map_or(Ok(()), |(process, (_, at_ns))| {
                    fail_if(true, || {
                        let ago = ms(moment.now_ns - at_ns);
                        format!("{} died {ago} ms ago, and nobody was told", process.name())
                    })
                });
            }
            _ => {}
        }
        Ok(())
    }
}
