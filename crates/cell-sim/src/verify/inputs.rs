//! What the processes heard, as far as it was recorded.

use std::collections::BTreeMap;

use ipc_types::header::Message as _;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmStatus, Decision, Header, Keyframe, MAX_ARMS};

use super::message::{Message, Recorded};
use super::report::Report;
use super::shelf::{Key, Sequence, Shelf, key};
use super::states::States;

/// The messages that others were computed from.
#[derive(Default)]
pub(super) struct Inputs {
    pub(super) states: States,
    pub(super) statuses: [Shelf<Box<ArmStatus>>; MAX_ARMS],
    pub(super) decisions: Shelf<Box<Decision>>,
    commands: [Sequence; MAX_ARMS],
}

impl Inputs {
    /// Takes a message in and says what is missing before it. `false` for one
    /// that is no news: it was recorded twice.
    pub(super) fn put(&mut self, message: &Message, report: &mut Report) -> bool {
        let (topic, missing, tick) = match message {
            Message::World(piece) => {
                let missing = self.states.put(piece);
                (TopicId::WorldState, missing, piece.state.tick)
            }
            Message::Status(arm, status) => {
                let Some(shelf) = self.statuses.get_mut(usize::from(*arm)) else {
                    return false;
                };
                let missing = shelf.put(key(&status.header), status.clone());
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
            Message::Keyframe(..) => return false,
        };
        report.gap(&topic.service(), missing, tick);
        true
    }

    /// Nothing more will come.
    pub(super) fn end(&mut self) {
        self.states.end();
        self.statuses.iter_mut().for_each(Shelf::end);
        self.decisions.end();
    }
}

/// Key of the input of `header` on `topic`.
pub(super) fn input(header: &Header, topic: TopicId) -> Option<Key> {
    let inputs = header.inputs().iter();
    let named = inputs.filter(|input| input.topic == topic.code());
    named.map(|input| (input.generation, input.seq)).next()
}

/// What a process remembered after a message.
pub(super) struct Checkpoint {
    pub(super) header: Header,
    pub(super) bytes: Vec<u8>,
}

/// The state records of a recording, by process, generation and the number of
/// the message they stand after.
#[derive(Default)]
pub(super) struct Checkpoints {
    records: BTreeMap<(Process, u32, u64), Checkpoint>,
    /// By process: a checkpoint of which parts are missing.
    parts: BTreeMap<Process, Checkpoint>,
}

impl Checkpoints {
    /// Collects them.
    pub(super) fn of(recorded: &(impl Recorded + ?Sized)) -> Self {
        let mut records = Self::default();
        // What cannot be read is said once, when the messages are taken.
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
        // Without the part before, which was not recorded, it is of no use.
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

    /// The checkpoint as of the message with `key`; number 0 for before the first.
    pub(super) fn after(&self, process: Process, key: Key) -> Option<&Checkpoint> {
        self.records.get(&(process, key.0, key.1))
    }
}
