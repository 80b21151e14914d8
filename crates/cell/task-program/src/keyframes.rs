//! Checkpoints of the task for the recorder.

use cell_bus::Publisher;
use ipc_types::{DECISION_TICKS, Header, Keyframe};

/// Interval of recorded checkpoints (ticks).
// A replay can start once a second (ADR 0012).
const PERIOD_TICKS: u64 = 1000;
/// Sends checkpoints, one part with each decision: in lockstep the recorder may be 15
/// decisions behind, and the buffer of the topic has room for 16 parts.
pub(crate) struct Keyframes {
    port: Publisher<Keyframe>,
    /// Period of simulated time in which a checkpoint was sent last.
    sent_in: Option<u64>,
    checkpoint: Vec<u8>,
    /// Number of its bytes that were sent.
    sent: usize,
    is_sending: bool,
    /// Header of the decision after which it was taken, and the number of that decision.
    of: Header,
    after_seq: u64,
}

impl Keyframes {
    pub(crate) fn new(port: Publisher<Keyframe>) -> Self {
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

    /// Once a second, and after a decision between two tenth ticks: the states there
    /// are recorded in part only. False while a long checkpoint is being sent.
    pub(crate) fn is_due(&mut self, tick: u64) -> bool {
        let period = tick / PERIOD_TICKS;
        let is_due = self.sent_in != Some(period) || !tick.is_multiple_of(DECISION_TICKS);
        // A second checkpoint would be mixed into the parts of the first, and neither could be
        // read.
        let is_due = is_due && !self.is_sending;
        if is_due {
            self.sent_in = Some(period);
        }
        is_due
    }

    /// Sends `checkpoint` next, as of the decision with number `after_seq` and this
    /// header: a process that restores it and receives the later inputs makes the same
    /// decisions.
    pub(crate) fn begin(&mut self, checkpoint: Vec<u8>, of: &Header, after_seq: u64) {
        self.checkpoint = checkpoint;
        self.of = *of;
        self.after_seq = after_seq;
        self.sent = 0;
        self.is_sending = true;
    }

    /// Sends the next part; false if it could not be sent.
    pub(crate) fn send(&mut self) -> bool {
        if !self.is_sending {
            return true;
        }
        let (checkpoint, offset) = (&self.checkpoint, self.sent);
        let (of, after_seq) = (&self.of, self.after_seq);
        let mut length = 0;
        let sent = self.port.publish(|message| {
            message.header = Header {
                inputs: of.inputs,
                input_count: of.input_count,
                ..Header::caused_by::<Keyframe>(of.tick)
            };
            message.after_seq = after_seq;
            message.reserved = 0;
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
