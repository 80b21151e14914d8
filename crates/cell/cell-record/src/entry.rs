//! One message of a recording.

use core::mem::offset_of;

use ipc_types::tap::PieceObject;
use ipc_types::{ClientInput, Keyframe, TICK_NS, Validate, Wire, WorldPiece};

use crate::channel::Channel;
use crate::error::RecordError;
use crate::pack::{MAX_BYTES, pack, unpack};

/// A message to be recorded.
#[derive(Clone, Copy, Debug)]
pub struct Message<'a> {
    /// Its channel.
    pub channel: Channel,
    /// Simulated time (ns).
    pub time_ns: u64,
    /// Publication time, of `CLOCK_MONOTONIC` (ns).
    pub publish_ns: u64,
    /// Its number.
    pub seq: u64,
    /// The message; a struct as it was sent.
    pub bytes: &'a [u8],
}

impl Message<'_> {
    /// The message in the format of a file, in `buffer`.
    pub fn packed<'b>(&self, buffer: &'b mut Vec<u8>) -> Message<'b> {
        buffer.clear();
        if self.channel.is_wire() {
            pack(self.bytes, buffer);
        } else {
            buffer.extend_from_slice(self.bytes);
        }
        Message {
            channel: self.channel,
            time_ns: self.time_ns,
            publish_ns: self.publish_ns,
            seq: self.seq,
            bytes: buffer,
        }
    }
}

/// A message that was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its channel.
    pub channel: Channel,
    /// Tick that caused it.
    pub tick: u64,
    /// Simulated time (ns).
    pub time_ns: u64,
    /// Publication time, of `CLOCK_MONOTONIC` (ns).
    pub publish_ns: u64,
    /// Its number, the low 32 bits of it.
    pub seq: u32,
    /// The message.
    pub bytes: Vec<u8>,
}

/// Messages that are cut after their used part.
pub trait Cut: Wire {
    /// Bytes that are always there.
    const LEAST: usize = size_of::<Self>();

    /// Bytes in use.
    fn used(&self) -> usize {
        size_of::<Self>()
    }
}

impl Cut for WorldPiece {
    const LEAST: usize = offset_of!(WorldPiece, objects);

    fn used(&self) -> usize {
        Self::LEAST + size_of_val(self.objects())
    }
}

impl Cut for Keyframe {
    const LEAST: usize = offset_of!(Keyframe, bytes);

    fn used(&self) -> usize {
        Self::LEAST + self.bytes().len()
    }
}

impl Cut for ClientInput {
    const LEAST: usize = offset_of!(ClientInput, bytes);

    fn used(&self) -> usize {
        Self::LEAST + self.bytes().len()
    }
}

impl Cut for ipc_types::ArmCommand {}
impl Cut for ipc_types::ArmStatus {}
impl Cut for ipc_types::Decision {}
impl Cut for ipc_types::TraceLine {}

// Cutting at `used` is valid only if nothing follows the variable part.
const _: () = assert!(
    offset_of!(WorldPiece, objects) + ipc_types::tap::PIECE_OBJECTS * size_of::<PieceObject>()
        == size_of::<WorldPiece>(),
    "only the end of a piece is cut"
);

/// The bytes of `message` that are recorded.
pub fn wire_bytes<T: Cut>(message: &T) -> &[u8] {
    const { assert!(size_of::<T>() <= MAX_BYTES, "a packed message would be cut") };
    let bytes = message.as_bytes();
    bytes.get(..message.used()).unwrap_or(bytes)
}

impl Entry {
    /// Simulated time (s).
    pub fn time_s(&self) -> f64 {
        self.time_ns as f64 / 1.0e9
    }

    /// The struct it holds, validated like one from the bus.
    ///
    /// # Errors
    ///
    /// [`RecordError::Message`] when it is of another size or has an invalid value.
    pub fn read<T: Cut + Validate>(&self) -> Result<T, RecordError> {
        let refuse = |reason: String| RecordError::Message {
            channel: self.channel.name(),
            tick: self.tick,
            reason,
        };
        let (least, most) = (T::LEAST, size_of::<T>());
        let size = self.bytes.len();
        if !(least..=most).contains(&size) {
            return Err(refuse(format!(
                "{size} bytes; {least} to {most} are a message of this version"
            )));
        }
        // The missing part is zeros, as `pack` leaves zeros out.
        let mut bytes = vec![0; most];
        for (to, from) in bytes.iter_mut().zip(&self.bytes) {
            *to = *from;
        }
        let message = T::from_bytes(&bytes).ok_or_else(|| refuse("cut".to_owned()))?;
        // The count in the message must not name entries that were cut off.
        if message.used() > size.max(least) {
            return Err(refuse(format!("cut after {size} bytes")));
        }
        match message.validate() {
            Ok(()) => Ok(message),
            Err(invalid) => Err(refuse(format!("{invalid:?}"))),
        }
    }

    pub(crate) fn of(channel: Channel, header: mcap::records::MessageHeader, data: &[u8]) -> Self {
        // Data that cannot be unpacked has no struct's size, and is refused when it is read.
        let bytes = if channel.is_wire() {
            unpack(data).unwrap_or_default()
        } else {
            data.to_vec()
        };
        Self {
            channel,
            // The file has simulated time; ticks follow from it, as
            // every message is of a whole tick.
            tick: header.log_time / TICK_NS,
            time_ns: header.log_time,
            publish_ns: header.publish_time,
            seq: header.sequence,
            bytes,
        }
    }

    /// As a message to be recorded again.
    pub fn message(&self) -> Message<'_> {
        Message {
            channel: self.channel,
            time_ns: self.time_ns,
            publish_ns: self.publish_ns,
            seq: u64::from(self.seq),
            bytes: &self.bytes,
        }
    }
}
