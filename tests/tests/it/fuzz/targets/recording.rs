//! Recordings: files of any origin.

use cell_record::{Channel, Message, Preamble, Recording, RecordingWriter, wire_bytes};
use cell_sim::eval::template;
use ipc_types::{ArmCommand, ArmStatus, Decision, Wire, WorldPiece};
use serde_json::json;

use super::Target;

pub(crate) const RECORDING: Target = Target {
    name: "recording",
    run: |bytes| {
        let Ok(file) = tempfile::NamedTempFile::new() else {
            return;
        };
        if std::fs::write(file.path(), bytes).is_err() {
            return;
        }
        let Ok(mut recording) = Recording::open(file.path()) else {
            return;
        };
        for entry in recording.messages() {
            let Ok(entry) = entry else { break };
            match entry.channel {
                Channel::World => drop(entry.read::<WorldPiece>().is_ok()),
                Channel::Command(_) => drop(entry.read::<ArmCommand>().is_ok()),
                Channel::Status(_) => drop(entry.read::<ArmStatus>().is_ok()),
                Channel::Decision => drop(entry.read::<Decision>().is_ok()),
                _ => {}
            }
        }
        let (from_s, to_s) = recording.span_s();
        let _frame = recording.at(0.5 * (from_s + to_s)).is_ok();
        let _lines = recording.log_until(to_s, 10).is_ok();
    },
    corpus: || written().into_iter().collect(),
};

/// A short recording.
fn written() -> Option<Vec<u8>> {
    let dir = tempfile::tempdir().ok()?;
    let path = dir.path().join("short.mcap");
    let scene = json!({ "demo": "d", "objects": [], "arms": [{ "name": "a" }] });
    let preamble = Preamble::new(&template("franka-stack", "fsm"), &scene);
    let mut writer = RecordingWriter::create(&path, &preamble).ok()?;
    let mut command = ArmCommand::zeroed();
    command.joint_count = 7;
    let mut decision = Decision::zeroed();
    for tick in 1..40_u64 {
        for (channel, bytes) in [
            (Channel::World, wire_bytes(&WorldPiece::zeroed()).to_vec()),
            (Channel::Command(0), wire_bytes(&command).to_vec()),
            (
                Channel::Status(0),
                wire_bytes(&ArmStatus::zeroed()).to_vec(),
            ),
            (Channel::Decision, wire_bytes(&decision).to_vec()),
        ] {
            let message = Message {
                channel,
                time_ns: tick * 1_000_000,
                publish_ns: tick,
                seq: tick,
                bytes: &bytes,
            };
            writer.add(&message).ok()?;
        }
        command.header.tick = tick;
        decision.header.tick = tick;
    }
    writer.finish().ok()?;
    std::fs::read(path).ok()
}
