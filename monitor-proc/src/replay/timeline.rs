//! The timeline of a whole recording.

use cell_record::Recording;
use serde_json::Value;

use super::page_record::{PageRecord, line_time_s};
use crate::feed::scene;
use crate::timeline::lanes::{Timeline, lane_states};
use crate::timeline::recorded::RecordingSource;
use crate::trace::log_line;

/// The newest lines of a recording that are searched for marks, and the marks that are shown.
// A page draws them all.
const SEARCHED_LINES: usize = 100_000;
const SHOWN_MARKS: usize = 2000;
/// Largest number of moments of a recording that are read, and their smallest distance (s).
// Two minutes of decisions; a page waits for the lanes of a longer recording not much longer.
const MOST_MOMENTS: f64 = 12_000.0;
// A decision: of several arms, the task names the phase of one in each.
const LEAST_S: f64 = 0.01;

/// The lanes; fewer if it `is_over` before all was read.
pub(super) fn lanes(
    recording: &mut Recording,
    record: &PageRecord,
    is_over: impl Fn() -> bool,
) -> Timeline {
    let arms = scene::arm_names(recording.scene());
    let objects = scene::object_names(recording.scene());
    let mut timeline = Timeline::default();
    let (from_s, to_s) = recording.span_s();
    let step_s = ((to_s - from_s) / MOST_MOMENTS).max(LEAST_S);
    let mut time_s = from_s;
    while time_s <= to_s && !is_over() {
        // At the start of a recording there may be no complete state yet.
        if let Ok(recorded) = recording.state_at(time_s) {
            let decision = Some(recorded.decision.as_ref());
            let at_s = recorded.world.header.sim_time_ns as f64 * 1.0e-9;
            let states = lane_states(&recorded.world, decision, &arms, &objects);
            timeline.update(at_s, None, states);
        }
        time_s += step_s;
    }
    let spans = record.spans.iter().cloned();
    spans.for_each(|span| timeline.add(span));
    timeline
}

/// Lines of the log that are marked, the newest ones of a long recording.
pub(super) fn marks(recording: &mut Recording, record: &PageRecord) -> Vec<Value> {
    let (_, to_s) = recording.span_s();
    let of_task = recording
        .log_until(to_s, SEARCHED_LINES)
        .unwrap_or_default();
    let mut marks: Vec<Value> = of_task.iter().map(log_line).collect();
    marks.extend(record.lines.iter().cloned());
    // The page marks these by their texts.
    let by_text = ["operator: pause", "[task] reset"];
    let is_marked = |line: &Value| {
        line["text"]
            .as_str()
            .is_some_and(|text| by_text.contains(&text))
    };
    marks.retain(|line| !line["mark"].is_null() || is_marked(line));
    marks.sort_by(|a, b| line_time_s(a).total_cmp(&line_time_s(b)));
    marks.drain(..marks.len().saturating_sub(SHOWN_MARKS));
    marks
}
