//! Verification of recordings on disk.

use std::path::{Path, PathBuf};

use cell_model::runs::policy_server::is_address;
use cell_record::{Channel, Entry, Recording};
use ipc_types::header::Message as Headed;
use ipc_types::{ArmCommand, ArmStatus, ClientInput, Decision, Keyframe, Wire, WorldPiece};

use super::message::{Message, Messages, Recorded};
use super::report::Report;
use super::{VerifyError, verify};
use crate::{Program, SimError};

/// Verifies the recording at `path`, a file or the directory of a flight recorder. Cell and
/// behaviours are read from `data`, or, if it is `None`, from where the run itself read them.
/// `on_tick` gets the tick of each message that was read, for a progress display.
///
/// # Errors
/// Returns [`SimError`] if the recording cannot be read, or its cell is not found.
pub fn verify_file(
    program: &Program,
    path: &Path,
    data: Option<PathBuf>,
    on_tick: &dyn Fn(u64),
) -> Result<Report, SimError> {
    let recording = Recording::open(path).map_err(VerifyError::from)?;
    let mut spec = recording.run().clone();
    spec.data_dir = data.or(spec.data_dir);
    if is_address(&spec.policy) {
        return Err(VerifyError::Server.into());
    }
    let cell = spec.load_cell_from(&program.data)?;
    let recorded = Followed {
        recording: &recording,
        on_tick,
    };
    let mut report = verify(program, &cell, &spec.policy, &recorded)?;
    // Needs the first difference, so it is a second pass over the file.
    report.read_before(&recording);
    Ok(Report {
        cut: recording.cut().map(str::to_owned),
        ..report
    })
}

/// A recording that reports its progress.
struct Followed<'a> {
    recording: &'a Recording,
    on_tick: &'a dyn Fn(u64),
}

impl Recorded for Followed<'_> {
    fn messages(&self) -> Messages<'_> {
        let entries = Recording::messages(self.recording);
        let told = entries.inspect(|entry| {
            if let Ok(entry) = entry {
                (self.on_tick)(entry.tick);
            }
        });
        Box::new(told.filter_map(|entry| message(&entry).transpose()))
    }
}

/// `None` for a channel that verification does not need.
pub(super) fn message(
    entry: &Result<Entry, cell_record::RecordError>,
) -> Result<Option<Message>, String> {
    let entry = entry.as_ref().map_err(ToString::to_string)?;
    Ok(Some(match entry.channel {
        Channel::World => Message::World(ours(entry, entry.read::<WorldPiece>())?),
        Channel::Command(arm) => Message::Command(arm, ours(entry, entry.read::<ArmCommand>())?),
        Channel::Status(arm) => Message::Status(arm, ours(entry, entry.read::<ArmStatus>())?),
        Channel::Decision => Message::Decision(ours(entry, entry.read::<Decision>())?),
        Channel::Client(arm) => Message::Client(arm, ours(entry, entry.read::<ClientInput>())?),
        Channel::Keyframe(process) => {
            Message::Keyframe(process, ours(entry, entry.read::<Keyframe>())?)
        }
        _ => return Ok(None),
    }))
}

/// A message whose layout is that of this build.
fn ours<T: Headed>(
    entry: &Entry,
    read: Result<T, cell_record::RecordError>,
) -> Result<Box<T>, String> {
    let message = read.map_err(|error| error.to_string())?;
    // Bytes of another layout have a valid length by chance only; compared they would differ in
    // every message, which would look like a defect of the controller.
    if message.header().schema == <T as Wire>::SCHEMA {
        return Ok(Box::new(message));
    }
    Err(format!(
        "channel {}: recorded by another version; use the build that recorded it",
        entry.channel.name()
    ))
}
