//! Time from a state to its command, of every tick: physics reports figures of a second only,
//! so the recording is read, which always exists.

use std::collections::BTreeMap;
use std::path::Path;

use cell_record::{Channel, RecordError, Recording};
use ipc_types::topic::TopicId;
use ipc_types::{ArmCommand, WorldPiece};

use crate::report::Samples;

/// Generation of its writer, and number.
type Key = (u32, u64);

/// From the publication of each state to that of the command of arm 0 computed from it.
pub(super) fn answers(flight_dir: &Path) -> Result<Samples, RecordError> {
    let recording = Recording::open(flight_dir)?;
    let mut sent: BTreeMap<Key, u64> = BTreeMap::new();
    let mut commands: Vec<(Key, u64)> = Vec::new();
    for entry in recording.messages() {
        let entry = entry?;
        match entry.channel {
            Channel::World => {
                let header = entry.read::<WorldPiece>()?.state;
                sent.insert((header.generation, header.seq), header.publish_ns);
            }
            Channel::Command(0) => {
                let header = entry.read::<ArmCommand>()?.header;
                let mut inputs = header.inputs().iter();
                let state = inputs.find(|input| input.topic == TopicId::WorldState.code());
                commands.extend(state.map(|s| ((s.generation, s.seq), header.publish_ns)));
            }
            _ => {}
        }
    }
    let mut samples = Samples::with_capacity(commands.len());
    // Commands whose state is not in the ring any more have no time.
    for (state, at_ns) in commands {
        if let Some(sent_ns) = sent.get(&state) {
            samples.record(at_ns.saturating_sub(*sent_ns));
        }
    }
    Ok(samples)
}
