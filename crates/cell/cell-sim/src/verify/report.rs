//! The result of a verification, for people and for programs.

use ipc_types::header::Message;
use schemars::JsonSchema;
use serde::Serialize;

use super::around::Around;
use super::difference::{Difference, first_field};
use super::message_window::Missing;

/// Gaps that are listed; all are counted, and a reader looks at the first ones.
const LISTED: usize = 20;

/// How many messages of a kind were compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Count {
    /// Computed again and compared.
    pub compared: u64,
    /// Of these, those that differ.
    pub different: u64,
    /// Not computed: before the first keyframe, or after something that was not
    /// recorded.
    pub skipped: u64,
}

impl Count {
    pub(super) fn add(&mut self, different: bool) {
        self.compared += 1;
        self.different += u64::from(different);
    }
}

/// Messages of a topic that were not recorded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Gap {
    /// Name of the topic.
    pub topic: String,
    /// Generation of its writer.
    pub generation: u32,
    /// Number of the first that is missing.
    pub first_seq: u64,
    /// How many are missing.
    pub missing: u64,
    /// Tick of the next that is there.
    pub until_tick: u64,
}

/// Result of verification.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Report {
    /// Commands of all arms.
    pub commands: Count,
    /// Statuses of all arms.
    pub statuses: Count,
    /// Decisions of the task. Skipped are also those made from a state between
    /// two tenth ticks, of which moving objects are not recorded.
    pub decisions: Count,
    /// State records, compared with what was computed from the one before.
    pub records: Count,
    /// Times computing began from a state record, all processes together.
    pub stretches: u64,
    /// Gaps in the topics that were recorded.
    pub gap_count: u64,
    /// The first of them.
    pub gaps: Vec<Gap>,
    /// Messages or parts of the recording that cannot be read.
    pub unreadable_count: u64,
    /// Reasons for the first 20 of them.
    pub unreadable: Vec<String>,
    /// Reason for which the recording ends early; messages after that are not compared.
    pub cut: Option<String>,
    /// The difference with the smallest tick.
    pub first_difference: Option<Difference>,
    /// That field half a second before and after it, where it is a number.
    #[serde(skip)]
    pub around: Vec<Around>,
    /// First and last tick that were compared.
    pub ticks: Option<(u64, u64)>,
}

/// The verdict in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// All that was compared is the same to the last bit.
    Same,
    /// Something differs.
    Different,
    /// Nothing could be compared.
    Nothing,
}

/// The verdict with its reasons, as JSON.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Verified<'a> {
    /// The verdict.
    pub verdict: Verdict,
    /// Its reasons.
    pub report: &'a Report,
}

impl Report {
    /// The verdict.
    pub fn verdict(&self) -> Verdict {
        // A difference counts even if few messages were compared; no message compared must not
        // read as success.
        if self.first_difference.is_some() {
            Verdict::Different
        } else if self.commands.compared + self.decisions.compared == 0 {
            Verdict::Nothing
        } else {
            Verdict::Same
        }
    }

    pub(super) fn unreadable(&mut self, what: String) {
        self.unreadable_count += 1;
        if self.unreadable.len() < LISTED {
            self.unreadable.push(what);
        }
    }

    pub(super) fn compared_at(&mut self, tick: u64) {
        let (first, last) = self.ticks.unwrap_or((tick, tick));
        self.ticks = Some((first.min(tick), last.max(tick)));
    }

    pub(super) fn gap(&mut self, topic: &str, missing: Option<Missing>, until_tick: u64) {
        let Some(missing) = missing else {
            return;
        };
        self.gap_count += 1;
        if self.gaps.len() < LISTED {
            self.gaps.push(Gap {
                topic: topic.to_owned(),
                generation: missing.generation,
                first_seq: missing.first_seq,
                missing: missing.count,
                until_tick,
            });
        }
    }

    /// Keeps the one with the smallest tick.
    pub(super) fn differs(&mut self, difference: Option<Difference>) {
        let Some(difference) = difference else {
            return;
        };
        let first = self.first_difference.as_ref();
        // Arms and task are computed independently and report in any order; the earliest
        // difference is the cause, later ones follow from it.
        if first.is_none_or(|first| difference.tick < first.tick) {
            self.first_difference = Some(difference);
            // Values collected so far belong to another field.
            self.around.clear();
        }
    }
}

/// Stamps `computed` with the header of `recorded` and compares all bytes. `None` if equal.
pub(super) fn compare<T: Message>(
    name: &str,
    recorded: &T,
    computed: &mut T,
) -> Option<Difference> {
    let stamped = *recorded.header();
    let header = computed.header_mut();
    // Identity and time of sending are not results of the computation. All other fields of the
    // header (tick, inputs, schema) are, and stay compared.
    header.run = stamped.run;
    header.generation = stamped.generation;
    header.seq = stamped.seq;
    header.publish_ns = stamped.publish_ns;
    if recorded.as_bytes() == computed.as_bytes() {
        return None;
    }
    let (field, recorded, computed) = first_field(recorded, computed);
    Some(Difference {
        message: name.to_owned(),
        generation: stamped.generation,
        seq: stamped.seq,
        tick: stamped.tick,
        field,
        recorded,
        computed,
    })
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rows = [
            ("commands", self.commands),
            ("statuses", self.statuses),
            ("decisions", self.decisions),
            ("state records", self.records),
        ];
        for (what, count) in rows {
            writeln!(
                f,
                "{what:14} {:8} compared {:6} different {:6} not compared",
                count.compared, count.different, count.skipped
            )?;
        }
        if let Some((first, last)) = self.ticks {
            let (first, last) = (first as f64 * 1.0e-3, last as f64 * 1.0e-3);
            let stretches = self.stretches;
            writeln!(
                f,
                "from {first:.3} s to {last:.3} s, in {stretches} stretches"
            )?;
        }
        for gap in &self.gaps {
            writeln!(
                f,
                "gap: {} messages of {} are missing before {:.3} s",
                gap.missing,
                gap.topic,
                gap.until_tick as f64 * 1.0e-3
            )?;
        }
        if self.gap_count > self.gaps.len() as u64 {
            writeln!(f, "{} gaps in all", self.gap_count)?;
        }
        for what in &self.unreadable {
            writeln!(f, "unreadable: {what}")?;
        }
        if let Some(cut) = &self.cut {
            let last_s = self.ticks.map_or(0.0, |(_, last)| last as f64 * 1.0e-3);
            writeln!(f, "the file ends early, at {last_s:.3} s: {cut}")?;
        }
        match (self.verdict(), &self.first_difference) {
            (_, Some(d)) => write!(
                f,
                "DIFFERENT first at tick {}: {} {} of generation {}: {}\n  recorded {}\n  computed {}",
                d.tick, d.message, d.seq, d.generation, d.field, d.recorded, d.computed
            ),
            (Verdict::Nothing, None) => write!(
                f,
                "NOTHING COMPARED: the recording holds no state record with the messages after it; \
                 record for longer than a second"
            ),
            _ => write!(f, "SAME: all compared bits"),
        }
    }
}
