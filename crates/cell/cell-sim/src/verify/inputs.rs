//! The recorded inputs of the processes.

use std::collections::BTreeMap;

use ipc_types::header::Message as _;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmStatus, ClientInput, Decision, Header, Keyframe, MAX_ARMS};

use super::message::{Message, Recorded};
use super::message_window::{Key, MessageWindow, Sequence, key};
use super::report::Report;
use super::states::States;

/// The messages from which others were computed.
#[derive(Default)]
pub(super) struct Inputs {
    pub(super) states: States,
    pub(super) statuses: [MessageWindow<Box<ArmStatus>>; MAX_ARMS],
    pub(super) decisions: MessageWindow<Box<Decision>>,
    pub(super) clients: [MessageWindow<Box<ClientInput>>; MAX_ARMS],
    commands: [Sequence; MAX_ARMS],
}

impl Inputs {
    /// Stores a message and reports a gap before it. `false` for a duplicate, which a recording
    /// may have where a recorder was restarted.
    pub(super) fn put(&mut self, message: &Message, report: &mut Report) -> bool {
        let (topic, missing, tick) = match message {
            Message::World(piece) => {
                let missing = self.states.put(piece);
                (TopicId::WorldState, missing, piece.state.tick)
            }
            Message::Status(arm, status) => {
                let Some(window) = self.statuses.get_mut(usize::from(*arm)) else {
                    return false;
                };
                let missing = window.put(key(&status.header), status.clone());
                (TopicId::ArmStatus(*arm), missing, status.header.tick)
            }
            Message::Command(arm, command) => {
                let key = key(&command.header);
                let sequence = self.commands.get_mut(usize::from(*arm));
                let Some(sequence) = sequence.filter(|sequence| !sequence.is_past(key)) else {
                    return false;
                };
                let missing = sequence.take(key);
                (TopicId::ArmCommand(*arm), missing, command.header.tick)
            }
            Message::Decision(decision) => {
                if self.decisions.has(key(&decision.header)) {
                    return false;
                }
                let missing = self.decisions.put(key(&decision.header), decision.clone());
                (TopicId::Decision, missing, decision.header.tick)
            }
            Message::Client(arm, input) => {
                let Some(window) = self.clients.get_mut(usize::from(*arm)) else {
                    return false;
                };
                let missing = window.put(key(&input.header), input.clone());
                (TopicId::ClientTap(*arm), missing, input.header.tick)
            }
            // Records were collected before the first message was taken.
            Message::Keyframe(..) => return false,
        };
        report.gap(&topic.service(), missing, tick);
        true
    }

    /// Marks the end of the recording: missing inputs will not follow.
    pub(super) fn end(&mut self) {
        self.states.end();
        self.statuses.iter_mut().for_each(MessageWindow::end);
        self.decisions.end();
        self.clients.iter_mut().for_each(MessageWindow::end);
    }
}

/// Key of the input of `header` on `topic`.
pub(super) fn input(header: &Header, topic: TopicId) -> Option<Key> {
    let inputs = header.inputs().iter();
    let named = inputs.filter(|input| input.topic == topic.code());
    named.map(|input| (input.generation, input.seq)).next()
}

/// The memory of a process after a message.
pub(super) struct Checkpoint {
    pub(super) header: Header,
    pub(super) bytes: Vec<u8>,
}

/// The state records of a recording, by process, generation and the number of the message after
/// which they were taken.
#[derive(Default)]
pub(super) struct Checkpoints {
    records: BTreeMap<(Process, u32, u64), Checkpoint>,
    /// Per process: a checkpoint whose last parts were not read yet.
    parts: BTreeMap<Process, Checkpoint>,
}

impl Checkpoints {
    /// Collects all records of a recording.
    pub(super) fn of(recorded: &(impl Recorded + ?Sized)) -> Self {
        let mut records = Self::default();
        // Unreadable messages are reported once, when `verify` takes the messages.
        for message in recorded.messages().flatten() {
            if let Message::Keyframe(process, keyframe) = message {
                records.take(process, &keyframe);
            }
        }
        records
    }

    fn take(&mut self, process: Process, keyframe: &Keyframe) {
        let header = *keyframe.header();
        if keyframe.offset == 0 {
            let bytes = Vec::new();
            self.parts.insert(process, Checkpoint { header, bytes });
        }
        let Some(mut checkpoint) = self.parts.remove(&process) else {
            return;
        };
        // The part before was not recorded: a checkpoint with a hole would restore wrong memory
        // and report differences that do not exist.
        if checkpoint.bytes.len() as u64 != keyframe.offset || keyframe.bytes().is_empty() {
            return;
        }
        checkpoint.bytes.extend(keyframe.bytes());
        if keyframe.is_last() {
            let at = (process, header.generation, keyframe.after_seq);
            self.records.insert(at, checkpoint);
        } else {
            self.parts.insert(process, checkpoint);
        }
    }

    /// The checkpoint after the message with `key`; number 0 means before the first message.
    pub(super) fn after(&self, process: Process, key: Key) -> Option<&Checkpoint> {
        self.records.get(&(process, key.0, key.1))
    }
}
