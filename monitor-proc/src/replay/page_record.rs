//! What the monitor added to the page when a recording was made: the channel `page`.

use std::collections::BTreeMap;

use cell_record::{RecordError, Recording};
use serde::Deserialize;
use serde_json::Value;

use crate::timeline::lanes::LaneSpan;

/// All messages of the channel.
#[derive(Clone, Debug, Default)]
pub(super) struct PageRecord {
    /// Lines of the log, in the order of simulated time.
    pub(super) lines: Vec<Value>,
    /// Spans of the timeline.
    pub(super) spans: Vec<LaneSpan>,
    /// Incidents as JSON, by number.
    pub(super) incidents: BTreeMap<u32, Vec<u8>>,
}

/// A message of the channel (docs/recording.md); an earlier version may have sent others.
#[derive(Deserialize)]
struct Message {
    #[serde(default)]
    lines: Vec<Value>,
    #[serde(default)]
    spans: Vec<LaneSpan>,
    incident: Option<Value>,
}

impl PageRecord {
    /// Reads the channel of `recording`.
    pub(super) fn read(recording: &mut Recording) -> Result<Self, RecordError> {
        let mut record = Self::default();
        for message in recording.page_messages()? {
            record.take(message);
        }
        // A line may have been reported after the restart that set simulated time back.
        record
            .lines
            .sort_by(|a, b| line_time_s(a).total_cmp(&line_time_s(b)));
        Ok(record)
    }

    fn take(&mut self, message: Value) {
        let Ok(message) = serde_json::from_value::<Message>(message) else {
            return;
        };
        self.lines
            .extend(message.lines.into_iter().filter(Value::is_object));
        // A recording is shown as one history.
        let spans = message.spans.into_iter();
        self.spans.extend(spans.map(|span| LaneSpan {
            epoch: None,
            ..span
        }));
        if let Some(incident) = message.incident {
            let number = incident["number"]
                .as_u64()
                .and_then(|n| u32::try_from(n).ok());
            self.incidents
                .extend(number.map(|number| (number, incident.to_string().into_bytes())));
        }
    }

    /// The lines up to `time_s`.
    pub(super) fn lines_until(&self, time_s: f64) -> &[Value] {
        let count = self
            .lines
            .partition_point(|line| line_time_s(line) <= time_s);
        self.lines.get(..count).unwrap_or_default()
    }
}

/// Simulated time of a line of the log (s).
pub(super) fn line_time_s(line: &Value) -> f64 {
    line["time_s"].as_f64().unwrap_or(0.0)
}
