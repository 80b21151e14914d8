//! Recordings made by a cell, and changed recordings.

use std::path::Path;

use cell_record::{Channel, Entry, Preamble, Recording, RecordingWriter};
use serde_json::Value;

use crate::program::{Said, finish, robocell};

/// `robocell replay FILE --verify`, with `more` arguments.
pub fn verify(base: &Path, file: &Path, more: &[&str]) -> Said {
    let file = file.display().to_string();
    let all: Vec<&str> = ["replay", &file, "--verify"]
        .into_iter()
        .chain(more.iter().copied())
        .collect();
    finish(robocell(base, &all))
}

/// The report of a verification (`--json`) that found everything the same.
///
/// # Panics
/// Where it did not.
pub fn same(said: &Said) -> Value {
    assert_eq!(said.code, 0, "{said:?}");
    let said = said.json();
    assert_eq!(said["verdict"], "same", "{said}");
    let report = &said["report"];
    for kind in ["commands", "statuses", "decisions", "records"] {
        assert_eq!(report[kind]["different"], 0, "{kind}: {said}");
    }
    assert_eq!(report["unreadable_count"], 0, "{said}");
    report.clone()
}

/// Writes the recording `from` to the new file `to`, with the scene and the
/// messages as `scene` and `message` change them.
///
/// # Panics
/// Where one cannot be read or the other not be written.
pub fn rewrite(
    from: &Path,
    to: &Path,
    scene: impl FnOnce(&mut Value),
    mut message: impl FnMut(&mut Entry),
) {
    let recording = Recording::open(from).expect("a recording");
    let mut shown = recording.scene().clone();
    scene(&mut shown);
    let preamble = Preamble::new(recording.run(), &shown);
    let mut writer = RecordingWriter::create(to, &preamble).expect("a new file");
    for entry in recording.messages() {
        let mut entry = entry.expect("a message that can be read");
        // The writer itself writes the start of a file.
        if !matches!(
            entry.channel,
            Channel::Run | Channel::Scene | Channel::SceneUpdate
        ) {
            message(&mut entry);
            writer.add(&entry.message()).expect("room on the disk");
        }
    }
    writer.finish().expect("room on the disk");
}
