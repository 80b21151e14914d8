//! The values of one field around the tick at which it first differs.

use cell_record::{Channel, Recording};
use ipc_types::header::Message as Headed;

use super::difference::{Difference, field_text};
use super::message::Message;
use super::recording::message;
use super::report::Report;

/// Half a second before the difference, and as much after it.
const TICKS: u64 = 500;

/// Values of a field in a recorded message and in the computed one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Around {
    /// Tick that caused the message.
    pub tick: u64,
    /// Its value in the recording.
    pub recorded: f64,
    /// Its value as computed; before the difference equal to the recorded one.
    pub computed: f64,
}

impl Report {
    /// Stores both values if the message follows the first difference and is of its kind.
    pub(super) fn follow<T: Headed>(&mut self, name: &str, recorded: &T, computed: &T) {
        let Some(first) = &self.first_difference else {
            return;
        };
        let tick = recorded.header().tick;
        if first.message != name || !(first.tick..=first.tick + TICKS).contains(&tick) {
            return;
        }
        let number = |message| number(message, &first.field);
        if let (Some(recorded), Some(computed)) = (number(recorded), number(computed)) {
            self.around.push(Around {
                tick,
                recorded,
                computed,
            });
        }
    }

    /// Adds the recorded values before the first difference.
    // Read from the file again: values before the difference are known to matter only once it
    // is found, and keeping them for every field would take memory for nothing.
    pub(super) fn read_before(&mut self, recording: &Recording) {
        let Some(first) = self.first_difference.as_ref() else {
            return;
        };
        let mut before = before(recording, first);
        before.append(&mut self.around);
        self.around = before;
    }
}

/// The value as a finite number; `None` for a text or a name.
fn number<T: Headed>(message: &T, field: &str) -> Option<f64> {
    let value: f64 = field_text(message, field)?.parse().ok()?;
    value.is_finite().then_some(value)
}

/// The messages before a difference. All of them that were compared are equal, so the recorded
/// value is used for both.
fn before(recording: &Recording, first: &Difference) -> Vec<Around> {
    let ticks = first.tick.saturating_sub(TICKS)..first.tick;
    let entries = recording.messages().filter(|entry| {
        let wanted = |entry: &cell_record::Entry| {
            ticks.contains(&entry.tick) && name(entry.channel) == first.message
        };
        entry.as_ref().is_ok_and(wanted)
    });
    let read = |entry| {
        let value = match message(&entry).ok()?? {
            Message::Command(_, command) => number(&*command, &first.field),
            Message::Status(_, status) => number(&*status, &first.field),
            Message::Decision(decision) => number(&*decision, &first.field),
            Message::World(_) | Message::Client(..) | Message::Keyframe(..) => None,
        }?;
        Some(Around {
            tick: entry.ok()?.tick,
            recorded: value,
            computed: value,
        })
    };
    entries.filter_map(read).collect()
}

/// Name of the messages of a channel, as in a difference; empty if they have no fields.
fn name(channel: Channel) -> String {
    match channel {
        Channel::Decision => "decision".to_owned(),
        Channel::Command(arm) => format!("command of arm {arm}"),
        Channel::Status(arm) => format!("status of arm {arm}"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use ipc_types::{Decision, Text, Wire as _};

    use super::super::report::compare;
    use super::*;

    fn decision(tick: u64, height: f64) -> Decision {
        let mut decision = Decision::zeroed();
        decision.header.tick = tick;
        decision.goals[0].target.position[2] = height;
        decision
    }

    fn follow(report: &mut Report, recorded: &Decision, mut computed: Decision) {
        let found = compare("decision", recorded, &mut computed);
        report.differs(found);
        report.follow("decision", recorded, &computed);
    }

    #[test]
    fn half_a_second_of_the_field_that_differs_is_kept() {
        let mut report = Report::default();
        for tick in (0..2000).step_by(10) {
            let recorded = decision(tick, 0.5);
            let height = if tick < 1000 { 0.5 } else { 0.75 };
            follow(&mut report, &recorded, decision(tick, height));
        }
        let ticks: Vec<u64> = report.around.iter().map(|one| one.tick).collect();
        assert_eq!((ticks.len(), ticks[0], ticks[50]), (51, 1000, 1500));
        let one = report.around[0];
        assert_eq!((one.recorded, one.computed), (0.5, 0.75));
        // An earlier difference, found later, takes its place.
        follow(&mut report, &decision(990, 0.1), decision(990, 0.2));
        assert_eq!(report.around.len(), 1);
    }

    #[test]
    fn a_text_is_not_kept() {
        let mut report = Report::default();
        let mut computed = decision(10, 0.0);
        computed.phase = Text::new("LIFT");
        follow(&mut report, &decision(10, 0.0), computed);
        assert!(report.first_difference.is_some() && report.around.is_empty());
    }
}
