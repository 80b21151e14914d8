//! The same through a file: a written file is read and verified, and a cut file up to its end.

use crate::verify_support;

use std::path::{Path, PathBuf};

use cell_record::{Channel, Preamble, RecordingWriter, wire_bytes};
use cell_sim::verify::{Message, Verdict, verify_file};
use ipc_types::Header;
use ipc_types::header::Message as _;
use verify_support::{Bench, Timing};

/// A file that is removed with the test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let name = format!("robocell-verify-{name}-{}.mcap", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::remove_file(&path).ok();
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).ok();
    }
}

fn write(bench: &Bench, path: &Path) {
    let preamble = Preamble::new(&bench.spec, &serde_json::json!({}));
    let writer = RecordingWriter::create(path, &preamble).expect("a new file");
    fill(bench, writer);
}

fn fill(bench: &Bench, mut writer: RecordingWriter) {
    for message in &bench.recorded {
        let (channel, header, bytes) = parts(message);
        let message = cell_record::Message {
            channel,
            time_ns: header.sim_time_ns,
            publish_ns: header.publish_ns,
            seq: header.seq,
            bytes,
        };
        writer.add(&message).expect("room on the disk");
    }
    writer.finish().expect("room on the disk");
}

fn parts(message: &Message) -> (Channel, &Header, &[u8]) {
    match message {
        Message::World(m) => (Channel::World, &m.header, wire_bytes(&**m)),
        Message::Command(arm, m) => (Channel::Command(*arm), m.header(), wire_bytes(&**m)),
        Message::Status(arm, m) => (Channel::Status(*arm), m.header(), wire_bytes(&**m)),
        Message::Decision(m) => (Channel::Decision, m.header(), wire_bytes(&**m)),
        Message::Client(arm, m) => (Channel::Client(*arm), m.header(), wire_bytes(&**m)),
        Message::Keyframe(of, m) => (Channel::Keyframe(*of), m.header(), wire_bytes(&**m)),
    }
}

#[test]
fn a_file_is_verified_and_an_altered_one_is_not() {
    let mut bench = Bench::new("franka-stack", "bt", "", Timing::default());
    bench.run(3_005);
    let file = Scratch::new("whole");
    write(&bench, &file.0);
    let report = verify_file(&crate::program(), &file.0, None, &|_| {}).expect("a report");
    assert_eq!(report.verdict(), Verdict::Same, "{report}");
    assert_eq!(
        (report.commands.compared, report.decisions.compared),
        (3_005, 301)
    );
    assert_eq!(report.cut, None);
    for message in &mut bench.recorded {
        if let Message::Decision(decision) = message
            && decision.header.tick == 2_000
        {
            decision.drops += 1;
        }
    }
    let other = Scratch::new("altered");
    write(&bench, &other.0);
    let report = verify_file(&crate::program(), &other.0, None, &|_| {}).expect("a report");
    let first = report.first_difference.expect("a difference");
    assert_eq!((first.tick, first.field.as_str()), (2_000, "drops"));
}

#[test]
fn a_file_that_ends_early_is_verified_as_far_as_it_goes() {
    let mut bench = Bench::new("franka-stack", "fsm", "", Timing::default());
    bench.run(4_005);
    let file = Scratch::new("cut");
    write(&bench, &file.0);
    let bytes = std::fs::read(&file.0).expect("the file");
    std::fs::write(&file.0, &bytes[..bytes.len() * 2 / 3]).expect("a shorter file");
    let report = verify_file(&crate::program(), &file.0, None, &|_| {}).expect("a report");
    assert_eq!(report.verdict(), Verdict::Same, "{report}");
    assert!(report.commands.compared > 1_000, "{report}");
    let said = report.to_string();
    assert!(said.contains("the file ends early, at "), "{said}");
    assert!(said.contains("in the middle of a record"), "{said}");
    assert!(verify_file(&crate::program(), Path::new("/nowhere.mcap"), None, &|_| {}).is_err());
}

#[test]
fn a_file_that_was_flushed_before_anything_was_said_is_verified() {
    // A recorder that waits for a paused cell flushes the data that the file does not have yet.
    let mut bench = Bench::new("reach", "follow", "", Timing::default());
    bench.run(1_500);
    let file = Scratch::new("early");
    let preamble = Preamble::new(&bench.spec, &serde_json::json!({}));
    let mut writer = RecordingWriter::create(&file.0, &preamble).expect("a new file");
    writer.flush().expect("room on the disk");
    fill(&bench, writer);
    let report = verify_file(&crate::program(), &file.0, None, &|_| {}).expect("a report");
    assert_eq!(report.verdict(), Verdict::Same, "{report}");
}
