//! A reader of another project reads every channel.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking; a skipped one says so"
)]

use crate::support;

use std::process::Command;

use cell_record::{Channel, RecordingWriter};

#[test]
fn the_mcap_package_of_python_reads_every_channel() {
    let known = Command::new("python3")
        .args(["-c", "import mcap.reader, lz4.frame"])
        .output();
    if !known.is_ok_and(|out| out.status.success()) {
        println!("skipped: python3 with the packages mcap and lz4 is not installed");
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.mcap");
    let mut writer = RecordingWriter::create(&path, &support::preamble()).unwrap();
    for tick in 0..1000 {
        support::tick(tick, |message| writer.add(message).unwrap());
    }
    writer.finish().unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/read.py");
    let out = Command::new("python3")
        .arg(script)
        .arg(&path)
        .output()
        .unwrap();
    let (said, trouble) = (&out.stdout, String::from_utf8_lossy(&out.stderr));
    assert!(out.status.success(), "{trouble}");
    let said = String::from_utf8_lossy(said);
    for line in [
        "arm/0/command 1000",
        "arm/0/status 1000",
        "world 1200",
        "decision 100",
        "log 10",
        "run 1",
        "joint 0.999",
    ] {
        assert!(said.lines().any(|l| l == line), "{line} in {said}");
    }
    let channels = said.lines().find(|l| l.starts_with("channels ")).unwrap();
    assert_eq!(channels, format!("channels {}", Channel::all(1).len()));
}
