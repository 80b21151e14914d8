//! States with their duration, lane by lane, for the timeline of the page
//! (docs/page-protocol.md, `timeline`).

use std::collections::VecDeque;

use ipc_types::decision::Outcome;
use ipc_types::topic::Process;
use ipc_types::{Decision, WorldState};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Number of spans kept, of all lanes together.
// A page draws them all.
const KEPT: usize = 4000;

/// An incident and a process that is not running are about the same failure up to this distance
/// (simulated s).
// A process is silent after a second, and its successor may need another.
const SAME_FAILURE_S: f64 = 2.0;

/// A restarted process is shown for at least this time (s).
// In lockstep simulated time waits for a restart, which would then have no length.
const LEAST_DOWN_S: f64 = 0.02;

/// A state from a moment on, until the next span of the lane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LaneSpan {
    /// Name of the lane.
    pub lane: String,
    /// Subject of the lane.
    pub kind: Kind,
    /// Simulated time (s).
    pub from_s: f64,
    /// Generation of physics; `None` where that is not known.
    pub epoch: Option<u32>,
    /// The state; empty for none.
    pub label: String,
    /// Severity of the state.
    pub tone: Tone,
}

impl LaneSpan {
    /// Whether the messages of the bus, and so a recording, have this state.
    pub fn is_recorded(&self) -> bool {
        match self.kind {
            Kind::Task | Kind::Phase | Kind::Grip => true,
            Kind::Process | Kind::Recording => false,
        }
    }
}

/// Subject of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Outcome of the task.
    Task,
    /// Phase of the policy.
    Phase,
    /// Object held by an arm.
    Grip,
    /// A process that is not running.
    Process,
    /// The file being written.
    Recording,
}

/// Severity of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "words of the page")]
pub enum Tone {
    Ok,
    Info,
    Warn,
    Bad,
    Dim,
}

/// Present state of a lane.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneState {
    lane: String,
    kind: Kind,
    label: String,
    tone: Tone,
}

impl LaneState {
    fn new(lane: impl Into<String>, kind: Kind, label: impl Into<String>, tone: Tone) -> Self {
        Self {
            lane: lane.into(),
            kind,
            label: label.into(),
            tone,
        }
    }

    /// A process; an empty `label` if it is running.
    pub fn process(process: Process, label: &str) -> Self {
        Self::new(process.name(), Kind::Process, label, Tone::Bad)
    }

    /// The file being written, or a gap in the recording.
    pub fn recording(file: &str, has_gap: bool) -> Self {
        let (label, tone) = if has_gap {
            ("gap", Tone::Bad)
        } else {
            (file, Tone::Info)
        };
        Self::new("recording", Kind::Recording, label, tone)
    }
}

/// Rows of the task and of the grippers. `arms` and `objects` are names in the order
/// of the cell file.
pub fn lane_states(
    world: &WorldState,
    decision: Option<&Decision>,
    arms: &[String],
    objects: &[String],
) -> Vec<LaneState> {
    let outcome = decision.and_then(|decision| Outcome::from_code(decision.outcome));
    let (label, tone) = match outcome.unwrap_or_default() {
        Outcome::Idle => ("idle", Tone::Dim),
        Outcome::Running => ("running", Tone::Info),
        Outcome::Done => ("done", Tone::Ok),
        Outcome::Failed => ("failed", Tone::Bad),
        Outcome::Paused => ("paused", Tone::Warn),
    };
    let phase = decision.map_or("", |decision| decision.phase.as_str());
    let mut lane_states = vec![LaneState::new("outcome", Kind::Task, label, tone)];
    lane_states.extend(phases(phase, arms));
    for (index, arm) in world.arms().iter().enumerate() {
        let held = (arm.gripper.held_object as usize).checked_sub(1);
        let held = held.and_then(|held| objects.get(held));
        let lane = match arms.get(index) {
            // One arm needs no name in its lane.
            Some(name) if arms.len() > 1 => format!("grip {name}"),
            _ => "grip".to_owned(),
        };
        let held = held.map_or("", String::as_str);
        lane_states.push(LaneState::new(lane, Kind::Grip, held, Tone::Ok));
    }
    lane_states
}

/// The phase, in the lane of its arm if there are several: a task of several arms names a phase
/// `LEFT_LIFT`, one arm's at a time.
fn phases(phase: &str, arms: &[String]) -> Vec<LaneState> {
    let state = |lane: String, label: &str| LaneState::new(lane, Kind::Phase, label, Tone::Info);
    let lane = |arm: &String| format!("phase {arm}");
    // Between two phases every lane is empty, or the last phase would seem to continue.
    if arms.len() > 1 && phase.is_empty() {
        return arms.iter().map(|arm| state(lane(arm), "")).collect();
    }
    let several = if arms.len() > 1 { arms } else { &[] };
    let of_arm = several.iter().find_map(|arm| {
        let (name, rest) = phase.split_at_checked(arm.len())?;
        let rest = rest.strip_prefix('_')?;
        // Names of arms may have characters that a phase has not; these are underscores there.
        let is_same = |(in_phase, of_arm): (char, char)| {
            in_phase.eq_ignore_ascii_case(&of_arm)
                || (in_phase == '_' && !of_arm.is_ascii_alphanumeric())
        };
        let is_arm = name.chars().zip(arm.chars()).all(is_same);
        is_arm.then(|| state(lane(arm), rest))
    });
    vec![of_arm.unwrap_or_else(|| state("phase".to_owned(), phase))]
}

/// All lanes.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    spans: VecDeque<LaneSpan>,
    /// The newest span of each lane, in the order to be drawn.
    newest: Vec<LaneSpan>,
    changes: Vec<LaneSpan>,
    /// The newest reason that no span has yet, with its simulated time (s): the incident can be
    /// known before the restart is seen.
    reason: Option<(f64, String)>,
}

impl Timeline {
    /// Takes the states of all lanes at `time_s` of `epoch`.
    pub fn update(
        &mut self,
        time_s: f64,
        epoch: Option<u32>,
        lane_states: impl IntoIterator<Item = LaneState>,
    ) {
        for state in lane_states {
            let newest = self.newest.iter().find(|span| span.lane == state.lane);
            let same = |span: &LaneSpan| {
                (span.epoch, &span.label, span.tone) == (epoch, &state.label, state.tone)
            };
            // Only changes are spans: a state that continues needs no new one.
            if !newest.is_some_and(same) {
                self.add(LaneSpan {
                    lane: state.lane,
                    kind: state.kind,
                    from_s: time_s,
                    epoch,
                    label: state.label,
                    tone: state.tone,
                });
            }
        }
    }

    /// Adds a span; it replaces one of the same lane, epoch and start.
    pub fn add(&mut self, span: LaneSpan) {
        match self.newest.iter_mut().find(|known| known.lane == span.lane) {
            // An older span, e.g. an explanation, must not become
            // the present state of its lane.
            Some(known) if known.epoch != span.epoch || known.from_s <= span.from_s => {
                *known = span.clone();
            }
            Some(_) => {}
            None => self.newest.push(span.clone()),
        }
        let place = |known: &LaneSpan| {
            (&known.lane, known.epoch) == (&span.lane, span.epoch)
                // Bits, as equal times have to be the same number, not close ones.
                && known.from_s.to_bits() == span.from_s.to_bits()
        };
        // Also of a replaced span: the page replaces it by the same rule.
        self.changes.push(span.clone());
        match self.spans.iter_mut().rev().find(|known| place(known)) {
            Some(known) => *known = span,
            None => self.spans.push_back(span),
        }
        if self.spans.len() > KEPT {
            self.spans.pop_front();
        }
    }

    /// A process was not running from `from_s` on, and is at `to_s`.
    pub fn add_downtime(&mut self, process: Process, epoch: Option<u32>, from_s: f64, to_s: f64) {
        let state = |label: &str| LaneState::process(process, label);
        // A silent process has a span already.
        let name = process.name();
        let newest = self.newest.iter().find(|span| span.lane == name);
        if newest.is_none_or(|span| span.label.is_empty()) {
            let reason = self.reason.take_if(|(at_s, what)| {
                what.starts_with(&*name) && (*at_s - from_s).abs() <= SAME_FAILURE_S
            });
            let label = reason.map_or_else(|| "restarted".to_owned(), |(_, what)| what);
            self.update(from_s, epoch, [state(&label)]);
        }
        // Simulated time goes back when physics resumes.
        self.update(to_s.max(from_s + LEAST_DOWN_S), epoch, [state("")]);
    }

    /// Adds the reason why a process was not running at `time_s`, in place of "restarted": `what`
    /// starts with its name.
    pub fn explain(&mut self, time_s: f64, what: &str) {
        let is_about = |span: &&LaneSpan| {
            span.kind == Kind::Process
                && matches!(&*span.label, "restarted" | "silent")
                && what.starts_with(&span.lane)
                && (span.from_s - time_s).abs() <= SAME_FAILURE_S
        };
        match self.spans.iter().rev().find(is_about).cloned() {
            Some(span) => self.add(LaneSpan {
                label: what.to_owned(),
                ..span
            }),
            None => self.reason = Some((time_s, what.to_owned())),
        }
    }

    /// Adds spans that an earlier start of the monitor sent.
    pub fn restore(&mut self, spans: impl IntoIterator<Item = LaneSpan>) {
        spans.into_iter().for_each(|span| self.add(span));
        self.changes.clear();
    }

    /// Changes since the last call.
    pub fn take_changes(&mut self) -> Vec<LaneSpan> {
        std::mem::take(&mut self.changes)
    }

    /// The message about `spans`; about all without an argument.
    pub fn message(&self, spans: Option<&[LaneSpan]>) -> Value {
        match spans {
            Some(spans) => json!({ "t": "lanes", "all": false, "spans": spans }),
            None => json!({ "t": "lanes", "all": true, "spans": self.spans }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phase(label: &str) -> LaneState {
        LaneState::new("phase", Kind::Phase, label, Tone::Info)
    }

    #[test]
    fn a_span_begins_where_something_changes_and_in_each_epoch() {
        let mut timeline = Timeline::default();
        timeline.update(1.0, Some(1), [phase("PICK")]);
        timeline.update(1.5, Some(1), [phase("PICK")]);
        timeline.update(2.0, Some(1), [phase("LIFT")]);
        timeline.update(1.2, Some(2), [phase("LIFT")]);
        let sent = timeline.take_changes();
        let begun: Vec<_> = sent.iter().map(|s| (s.from_s, s.label.as_str())).collect();
        assert_eq!(begun, [(1.0, "PICK"), (2.0, "LIFT"), (1.2, "LIFT")]);
        assert!(timeline.take_changes().is_empty());
    }

    #[test]
    fn each_of_several_arms_has_a_lane_for_its_phase() {
        let arms = ["left".to_owned(), "right".to_owned()];
        let mut timeline = Timeline::default();
        for (time_s, phase) in [
            (0.0, ""),
            (1.0, "LEFT_LIFT"),
            (2.0, "RIGHT_PICK"),
            (3.0, "LEFT_PLACE"),
        ] {
            timeline.update(time_s, Some(1), phases(phase, &arms));
        }
        let sent = timeline.take_changes();
        let sent: Vec<_> = sent
            .iter()
            .map(|s| (s.from_s, s.lane.as_str(), s.label.as_str()))
            .collect();
        let begins = [(0.0, "phase left", ""), (0.0, "phase right", "")];
        assert_eq!(sent[..2], begins);
        let then = [
            (1.0, "phase left", "LIFT"),
            (2.0, "phase right", "PICK"),
            (3.0, "phase left", "PLACE"),
        ];
        assert_eq!(sent[2..], then);
        let alone = phases("LEFT_LIFT", &arms[..1]);
        assert_eq!(
            (alone[0].lane.as_str(), alone[0].label.as_str()),
            ("phase", "LEFT_LIFT")
        );
    }

    #[test]
    fn the_reason_of_a_restart_takes_the_place_of_its_name() {
        let mut timeline = Timeline::default();
        let physics = Process::Physics;
        timeline.update(0.0, Some(1), [LaneState::process(physics, "")]);
        timeline.add_downtime(physics, Some(1), 3.0, 3.1);
        timeline.explain(3.0, "physics was killed by signal 9");
        let spans = timeline.message(None)["spans"].clone();
        let labels: Vec<_> = spans
            .as_array()
            .unwrap()
            .iter()
            .map(|s| &s["label"])
            .collect();
        assert_eq!(labels, ["", "physics was killed by signal 9", ""]);
        // The reason can be known first, and is not that of the failure before.
        timeline.explain(6.0, "physics hangs");
        timeline.add_downtime(physics, Some(1), 6.1, 6.2);
        timeline.add_downtime(physics, Some(1), 9.0, 9.1);
        let added = timeline.take_changes();
        let added: Vec<_> = added.iter().map(|s| s.label.as_str()).collect();
        assert_eq!(added[4..], ["physics hangs", "", "restarted", ""]);
        // It is running: no change.
        timeline.take_changes();
        timeline.update(4.0, Some(1), [LaneState::process(physics, "")]);
        assert!(timeline.take_changes().is_empty());
    }
}
