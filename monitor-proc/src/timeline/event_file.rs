//! The page's log and the lanes of its timeline as files of the run: a restarted monitor, and a
//! page opened late, show the earlier lines.

use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use cell_run::spec::RunSpec;
use serde_json::{Value, json};

use crate::feed::broadcast::Broadcast;
use crate::timeline::incidents::IncidentWatch;
use crate::timeline::lanes::LaneSpan;
use crate::trace::KEPT_LINES;

/// The log of the page.
const EVENTS: &str = "events.jsonl";
/// The lanes of its timeline.
const LANES: &str = "lanes.jsonl";
/// Size at which a file is cut to the lines that are shown (bytes).
// The run directory is in memory.
const LIMIT_BYTES: u64 = 1 << 20;

/// The files of a run, and what an earlier start of the monitor wrote there.
pub(crate) struct PageFiles {
    events: EventFile,
    lanes: EventFile,
    /// The log.
    lines: Vec<Value>,
    /// The spans of the lanes.
    spans: Vec<Value>,
}

impl PageFiles {
    /// The files in `logs`.
    pub(crate) fn open(logs: &Path) -> Self {
        let (events, lines) = EventFile::open(logs, EVENTS);
        let (lanes, spans) = EventFile::open(logs, LANES);
        Self {
            events,
            lanes,
            lines,
            spans,
        }
    }

    /// Shows what an earlier start of the monitor of `spec` showed.
    pub(crate) fn restore_into(&self, broadcast: &Broadcast, spec: &RunSpec) {
        broadcast.restore_log(self.lines.clone());
        let spans = self.spans.iter().cloned().map(serde_json::from_value);
        let spans: Vec<LaneSpan> = spans.filter_map(Result::ok).collect();
        broadcast.change_timeline(|timeline| timeline.restore(spans));
        // Warnings of the run are in the log already if this is a later start.
        if self.lines.is_empty() {
            spec.warnings.iter().for_each(|text| broadcast.warn(text));
        }
    }

    /// The watch that does not report the incidents of the log so far again.
    pub(crate) fn incidents(&self, spec: &RunSpec) -> IncidentWatch {
        let numbers = self
            .lines
            .iter()
            .filter_map(|line| line["incident"].as_u64());
        let numbers: Vec<u64> = numbers.collect();
        let newest = numbers.iter().copied().max().unwrap_or(0);
        let of_newest = numbers.iter().filter(|number| **number == newest).count();
        IncidentWatch::new(spec, u32::try_from(newest).unwrap_or(0), of_newest)
    }

    /// Appends new lines of the log, and spans.
    pub(crate) fn append(&mut self, lines: &[Value], spans: &[LaneSpan]) {
        self.events.append(lines);
        let spans: Vec<Value> = spans.iter().map(|span| json!(span)).collect();
        self.lanes.append(&spans);
    }
}

/// Appends lines of the log, one JSON object each. Lines that the disk refuses are missing
/// after a restart of the monitor, and nowhere else.
struct EventFile {
    path: PathBuf,
    file: Option<File>,
}

impl EventFile {
    /// The file `name` in `logs`, and the last lines of it.
    fn open(logs: &Path, name: &str) -> (Self, Vec<Value>) {
        let path = logs.join(name);
        let lines = last_lines(&path);
        let file = append_to(&path);
        (Self { path, file }, lines)
    }

    /// Appends `lines`.
    fn append(&mut self, lines: &[Value]) {
        let Some(file) = self.file.as_mut().filter(|_| !lines.is_empty()) else {
            return;
        };
        // Failures are ignored: the page has the lines, and the next start has fewer.
        let written = file.write_all(text(lines).as_bytes()).is_ok();
        let bytes = file.metadata().map_or(0, |meta| meta.len());
        if written && bytes > LIMIT_BYTES {
            self.cut();
        }
    }

    /// Keeps the last lines in a new file.
    fn cut(&mut self) {
        let next = self.path.with_extension("next");
        let kept = text(&last_lines(&self.path));
        // A new file and a rename: a kill here leaves the long file or the short one.
        if fs::write(&next, kept).is_ok() && fs::rename(&next, &self.path).is_ok() {
            self.file = append_to(&self.path);
        }
    }
}

/// One line each.
fn text(lines: &[Value]) -> String {
    let mut text = String::new();
    for line in lines {
        text.push_str(&line.to_string());
        text.push('\n');
    }
    text
}

fn append_to(path: &Path) -> Option<File> {
    let opened = OpenOptions::new().create(true).append(true).open(path);
    opened.ok()
}

/// The last complete lines.
fn last_lines(path: &Path) -> Vec<Value> {
    let Ok(file) = File::open(path) else {
        return Vec::new();
    };
    let lines = BufReader::new(file).lines().map_while(Result::ok);
    let mut lines: Vec<Value> = lines
        // A line cut off by a kill is not JSON and is dropped.
        .filter_map(|line| serde_json::from_str(&line).ok())
        .filter(Value::is_object)
        .collect();
    lines.drain(..lines.len().saturating_sub(KEPT_LINES));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_lines_are_told_again_and_the_file_stays_small() {
        let dir = tempfile::tempdir().unwrap();
        let (mut events, before) = EventFile::open(dir.path(), EVENTS);
        assert!(before.is_empty());
        let line = |number: u32| json!({ "time_s": number, "text": "x".repeat(2000) });
        for number in 0..2000 {
            events.append(&[line(number)]);
        }
        let path = dir.path().join(EVENTS);
        assert!(fs::metadata(&path).unwrap().len() <= LIMIT_BYTES);
        // Killed in the middle of a line.
        let mut file = OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(b"{\"time_s\": 3").unwrap();
        let (_, lines) = EventFile::open(dir.path(), EVENTS);
        assert_eq!(lines.len(), KEPT_LINES);
        assert_eq!(lines.last(), Some(&line(1999)));
    }
}
