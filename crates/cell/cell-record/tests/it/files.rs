//! Files are read back as written, up to a cut.

use crate::support;

use std::path::Path;

use cell_record::{Channel, Message, Recording, RecordingWriter};
use ipc_types::ArmStatus;

fn record(path: &Path, ticks: u64) {
    let mut writer = RecordingWriter::create(path, &support::preamble()).unwrap();
    for tick in 0..ticks {
        support::tick(tick, |message| writer.add(message).unwrap());
    }
    writer.finish().unwrap();
}

#[test]
fn every_message_comes_back_bit_for_bit_and_in_order() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    record(&path, 1500);
    let recording = Recording::open(&path).unwrap();
    assert_eq!(recording.span_s(), (0.0, 1.499));
    assert_eq!(recording.run(), &support::run());
    assert_eq!(recording.scene(), &support::scene());
    assert_eq!(recording.cut(), None);
    let mut sent = Vec::new();
    for tick in 0..1500 {
        support::tick(tick, |m| {
            sent.push((m.channel, m.time_ns, m.publish_ns, m.bytes.to_vec()));
        });
    }
    let read = recording.messages().map(|entry| entry.unwrap());
    let own = read.filter(|entry| entry.channel.is_wire());
    let read: Vec<_> = own
        .map(|e| (e.channel, e.time_ns, e.publish_ns, e.bytes))
        .collect();
    assert!(read == sent, "{} of {}", read.len(), sent.len());
}

#[test]
fn a_moment_is_put_together_from_pieces() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    record(&path, 3000);
    let mut recording = Recording::open(&path).unwrap();
    for tick in [1234, 7, 2999, 2990, 0] {
        let frame = recording.at(tick as f64 / 1000.0).unwrap();
        let state = support::state(tick);
        assert_eq!(frame.world.objects(), state.objects(), "{tick}");
        assert_eq!(frame.world.arms, state.arms);
        assert_eq!(frame.status[0].cycles, tick);
        assert_eq!(frame.decision.header.tick, tick / 10 * 10);
    }
    assert_eq!(recording.at(99.0).unwrap().world.header.tick, 2999);
    let texts = |lines: Vec<ipc_types::TraceLine>| -> Vec<String> {
        lines.iter().map(|line| line.text.to_string()).collect()
    };
    let log = recording.log_until(1.25, 2).unwrap();
    assert_eq!(texts(log), ["line 1100", "line 1200"]);
    let trace = recording.trace(0.1, 0.3).unwrap();
    assert_eq!(texts(trace), ["line 200", "line 300"]);
}

#[test]
fn what_the_page_was_told_of_the_end_of_an_epoch_is_part_of_the_next() {
    let dir = tempfile::tempdir().unwrap();
    let (path, out) = (dir.path().join("a.mcap"), dir.path().join("b.mcap"));
    let mut writer = RecordingWriter::create(&path, &support::preamble()).unwrap();
    for tick in 0..3000 {
        support::tick(tick, |message| writer.add(message).unwrap());
    }
    let told = Message {
        channel: Channel::Page,
        time_ns: 2_999_000_000,
        publish_ns: 0,
        seq: 0,
        bytes: br#"{"lines":[{"text":"killed"}]}"#,
    };
    writer.add(&told).unwrap();
    // Physics resumed 0.5 s earlier.
    writer.begin_epoch(2, 2_500_000_000).unwrap();
    for tick in 2500..4000 {
        support::tick(tick, |message| writer.add(message).unwrap());
    }
    writer.finish().unwrap();
    let mut recording = Recording::open(&path).unwrap();
    let texts = |recording: &mut Recording| -> Vec<String> {
        let messages = recording.page_messages().unwrap();
        messages
            .iter()
            .map(|m| m["lines"][0]["text"].to_string())
            .collect()
    };
    assert_eq!(texts(&mut recording), ["\"killed\""]);
    recording.copy_span(2.0, 3.9, &out).unwrap();
    let mut copy = Recording::open(&out).unwrap();
    assert_eq!(texts(&mut copy), ["\"killed\""]);
    assert_eq!(copy.span_s().1, 3.9);
    assert_eq!(copy.at(2.7).unwrap().world.header.tick, 2700);
}

#[test]
fn a_span_is_a_recording_of_its_own_that_begins_at_a_keyframe() {
    let dir = tempfile::tempdir().unwrap();
    let (path, out) = (dir.path().join("a.mcap"), dir.path().join("b.mcap"));
    record(&path, 5000);
    let recording = Recording::open(&path).unwrap();
    recording.copy_span(3.5, 4.0, &out).unwrap();
    let mut copy = Recording::open(&out).unwrap();
    let (from_s, to_s) = copy.span_s();
    assert!(
        (from_s - 2.4).abs() < 0.01 && to_s == 4.0,
        "{from_s} {to_s}"
    );
    assert_eq!(copy.run(), recording.run());
    let keys = copy.messages().map(|e| e.unwrap().channel);
    let keys = keys.filter(|c| matches!(c, Channel::Keyframe(_))).count();
    assert_eq!(keys, 2);
    assert_eq!(
        copy.at(3.5).unwrap().world.objects(),
        support::state(3500).objects()
    );
    assert!(
        recording.copy_span(3.5, 4.0, &out).is_err(),
        "never over a file"
    );
}

#[test]
fn a_file_that_was_cut_anywhere_says_so_or_is_read_up_to_there() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    record(&path, 1000);
    let whole = std::fs::read(&path).unwrap();
    let cut = dir.path().join("cut.mcap");
    let (mut read, mut refused) = (0, 0);
    let step = (whole.len() / 60).max(1);
    for end in (0..40).chain((40..whole.len()).step_by(step)) {
        std::fs::write(&cut, &whole[..end]).unwrap();
        match Recording::open(&cut) {
            Ok(mut recording) => {
                read += 1;
                assert!(recording.messages().all(|entry| entry.is_ok()));
                let _state = recording.at(0.5);
            }
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains("cut.mcap"), "{error}");
            }
        }
    }
    assert!(read > 10 && refused >= 40, "{read} {refused}");
}

#[test]
fn bytes_that_were_changed_are_found_and_nothing_panics() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    record(&path, 300);
    let whole = std::fs::read(&path).unwrap();
    let bad = dir.path().join("bad.mcap");
    let mut troubles = 0;
    for at in (0..whole.len()).step_by(whole.len() / 150) {
        let mut bytes = whole.clone();
        for byte in bytes.iter_mut().skip(at).take(8) {
            *byte = 0xff;
        }
        std::fs::write(&bad, &bytes).unwrap();
        match Recording::open(&bad) {
            Ok(mut recording) => {
                troubles += recording.messages().filter(Result::is_err).count();
                let _state = recording.at(0.2);
                let _lines = recording.log_until(1.0, 10);
            }
            Err(_) => troubles += 1,
        }
    }
    assert!(troubles > 10, "{troubles}");
}

#[test]
fn a_message_of_another_version_and_a_file_of_somebody_else_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let mut writer = RecordingWriter::create(&path, &support::preamble()).unwrap();
    writer
        .add(&Message {
            channel: Channel::Status(0),
            time_ns: 1_000_000,
            publish_ns: 0,
            seq: 1,
            bytes: &[1, 2, 3],
        })
        .unwrap();
    writer.finish().unwrap();
    let recording = Recording::open(&path).unwrap();
    let entry = recording.messages().map(Result::unwrap);
    let entry = entry
        .filter(|e| e.channel == Channel::Status(0))
        .last()
        .unwrap();
    let why = entry.read::<ArmStatus>().unwrap_err().to_string();
    assert!(
        why.contains("arm/0/status") && why.contains("3 bytes"),
        "{why}"
    );
    let text = dir.path().join("text.mcap");
    std::fs::write(&text, "not a recording at all").unwrap();
    let why = Recording::open(&text).err().unwrap().to_string();
    assert!(why.contains("not an MCAP"), "{why}");
}
