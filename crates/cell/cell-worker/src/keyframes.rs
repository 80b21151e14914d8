//! Checkpoints of a process for the recorder.

use cell_bus::Publisher;
use ipc_types::{Header, Keyframe};

/// Interval of recorded checkpoints (ticks).
// A replay starts at a checkpoint, at most a second before the tick of interest (ADR 0012).
const KEYFRAME_TICKS: u64 = 1000;

/// Publishes checkpoints: a process that restores one and receives the later inputs publishes
/// the same messages. A long one is sent in parts, one with each message of its process: in
/// lockstep the recorder may be 15 decisions behind, and the buffer of the topic has room for
/// 16 parts.
pub struct Keyframes {
    port: Publisher<Keyframe>,
    /// Period of simulated time in which a checkpoint was sent last.
    sent_in: Option<u64>,
    checkpoint: Vec<u8>,
    /// Number of its bytes that were sent.
    sent: usize,
    is_sending: bool,
    /// Header of the message after which it was taken, and the number of that message.
    of: Header,
    after_seq: u64,
}

impl Keyframes {
    /// Checkpoints on `port`; none is due yet.
    pub fn new(port: Publisher<Keyframe>) -> Self {
        Self {
            port,
            sent_in: None,
            checkpoint: Vec::new(),
            sent: 0,
            is_sending: false,
            of: ipc_types::Wire::zeroed(),
            after_seq: 0,
        }
    }

    /// True once a second of simulated time, and where a replay needs `one_more`. False while a
    /// long checkpoint is being sent.
    pub fn is_due(&mut self, tick: u64, one_more: bool) -> bool {
        let period = tick / KEYFRAME_TICKS;
        let is_due = self.sent_in != Some(period) || one_more;
        // A second checkpoint would be mixed into the parts of the first, and neither could be
        // read.
        let is_due = is_due && !self.is_sending;
        if is_due {
            self.sent_in = Some(period);
        }
        is_due
    }

    /// Publishes the checkpoint that `save` writes into the message, as of the message with
    /// number `after_seq` and this header; `save` returns its length, or `None` where it does
    /// not fit. Allocates nothing. False if it was not sent whole.
    pub fn send_whole(
        &mut self,
        of: &Header,
        after_seq: u64,
        save: impl FnOnce(&mut [u8]) -> Option<usize>,
    ) -> bool {
        let mut fits = true;
        let sent = self.port.publish(|message| {
            begin_message(message, of, after_seq);
            let length = save(&mut message.bytes);
            fits = length.is_some();
            // The length fits: the array has that many bytes.
            message.len = length.map_or(0, |length| u32::try_from(length).unwrap_or(0));
            (message.offset, message.total) = (0, u64::from(message.len));
        });
        fits && sent.is_ok()
    }

    /// Sends `checkpoint` next, as of the message with number `after_seq` and this header.
    pub fn begin(&mut self, checkpoint: Vec<u8>, of: &Header, after_seq: u64) {
        self.checkpoint = checkpoint;
        self.of = *of;
        self.after_seq = after_seq;
        self.sent = 0;
        self.is_sending = true;
    }

    /// Sends the next part; false if it could not be sent.
    pub fn send(&mut self) -> bool {
        if !self.is_sending {
            return true;
        }
        let (checkpoint, offset) = (&self.checkpoint, self.sent);
        let (of, after_seq) = (&self.of, self.after_seq);
        let mut length = 0;
        let sent = self.port.publish(|message| {
            begin_message(message, of, after_seq);
            message.set(checkpoint, offset);
            length = message.bytes().len();
        });
        // A part that was not sent is not repeated: a reader finds the gap and skips this
        // checkpoint, and the next one follows within a second.
        self.sent += length;
        self.is_sending = sent.is_ok() && self.sent < self.checkpoint.len();
        sent.is_ok()
    }
}

/// Fills in all but the checkpoint.
fn begin_message(message: &mut Keyframe, of: &Header, after_seq: u64) {
    message.header = Header {
        inputs: of.inputs,
        input_count: of.input_count,
        ..Header::caused_by::<Keyframe>(of.tick)
    };
    message.after_seq = after_seq;
    message.reserved = 0;
}
