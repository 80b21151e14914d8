//! Snapshots: the whole world as bytes, for reset, restart and replay. A restored world
//! continues to the bit as the saved one would have.
//!
//! What can go wrong: bytes of another cell, seed or engine restore without an error and move
//! differently, or a damaged file ends the process. So a stamp of cell and engine is compared
//! first, a broken length allocates no more than the file has bytes, and nothing of the world
//! changes before all of it was read. A component of the world saves and restores its own part;
//! a new field of it that decides the next tick has to be in that part, or a kill loses it.

use bincode::Options;
use cell_model::Cell;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::WorldError;
use crate::state::hash::StateHash;

/// Stamp of a snapshot: one of another engine or another cell is refused.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
struct Stamp {
    magic: [u8; 8],
    engine: String,
    cell: u64,
}

fn stamp(fingerprint: u64) -> Stamp {
    Stamp {
        magic: *b"robocell",
        // The bytes of the engine change between its versions and carry no version number.
        engine: rapier3d_f64::VERSION.to_owned(),
        cell: fingerprint,
    }
}

/// `most` keeps a broken length from allocating more memory than the bytes can fill.
fn codec(most: usize) -> impl Options {
    bincode::DefaultOptions::new()
        // A fixed width keeps encoding fast; it is done within a tick.
        .with_fixint_encoding()
        .with_limit(most as u64)
}

/// Number that identifies a cell as it was set up: names, bases, masses, frictions, poses.
pub(crate) fn fingerprint(cell: &Cell) -> u64 {
    let mut hash = StateHash::new(1);
    let mut name = |text: &str| hash.numbers(&text.bytes().map(f64::from).collect::<Vec<_>>());
    name(&cell.name);
    cell.arms.iter().for_each(|arm| name(&arm.robot.name));
    cell.objects.iter().for_each(|object| name(&object.name));
    // Properties that decide the motion: a snapshot of other masses would restore and then
    // differ.
    for arm in &cell.arms {
        hash.numbers(&arm.home);
        hash.numbers(arm.base.translation.vector.as_slice());
        hash.numbers(arm.base.rotation.coords.as_slice());
        hash.numbers(
            &arm.robot
                .links
                .iter()
                .map(|link| link.mass)
                .collect::<Vec<_>>(),
        );
    }
    for object in &cell.objects {
        hash.numbers(&[object.mass, object.friction]);
        hash.numbers(&[object.shape.bounding_radius()]);
        hash.numbers(object.pose.translation.vector.as_slice());
        hash.numbers(object.pose.rotation.coords.as_slice());
    }
    hash.numbers(&[cell.bins as f64, cell.seed as f64]);
    hash.finish()
}

/// Appends a state to `out`: as bytes, of any size. Less than a state, which
/// [`decode`] refuses, if the engine cannot be written, which no state of a cell causes.
pub(crate) fn encode(fingerprint: u64, state: &impl Serialize, out: &mut Vec<u8>) {
    let parts = (stamp(fingerprint), state);
    codec(usize::MAX).serialize_into(out, &parts).ok();
}

/// The state in `bytes`, of the cell with this fingerprint.
///
/// # Errors
/// [`WorldError::Snapshot`] for bytes of another cell, engine or program.
pub(crate) fn decode<T: DeserializeOwned>(fingerprint: u64, bytes: &[u8]) -> Result<T, WorldError> {
    let refuse = |reason: String| WorldError::Snapshot { reason };
    let mut reader = bytes;
    let found: Stamp = codec(bytes.len())
        // The stamp is read alone first: the rest of another engine's snapshot may not parse
        // at all, and the message has to name the reason.
        .allow_trailing_bytes()
        .deserialize_from(&mut reader)
        .map_err(|e| refuse(format!("it is damaged ({e})")))?;
    if found != stamp(fingerprint) {
        return Err(refuse(
            "it is of another cell, seed or engine version".to_owned(),
        ));
    }
    codec(bytes.len())
        .deserialize_from(reader)
        .map_err(|e| refuse(format!("it is damaged ({e})")))
}
