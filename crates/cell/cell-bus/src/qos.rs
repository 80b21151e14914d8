//! Settings of the services: made by the keeper, adopted by all others.
//!
//! All memory is reserved when a port is created, for the worst case. So each number here is
//! shared memory in every run, and `needed_bytes` has to know all of them: a page that is
//! missing ends a process by SIGBUS at its first write, not at creation.

use ipc_types::tap::PIECE_OBJECTS;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{
    ArmCommand, ArmStatus, ClientInput, Contacts, Decision, Health, Keyframe, MAX_OBJECTS,
    TraceLine, WorldPiece, WorldState,
};

/// One writer is legal (the fence sees to it); the rest is slack for slots of
/// writers killed while they started, which are never given back.
// Exhausted slots stay exhausted while the service exists. With one slot, some 140 kills during
// start-up took it for good, and every later start failed.
pub(crate) const MAX_PUBLISHERS: usize = 8;
/// Processes of a cell, tools that look on, and slack as above.
// A cell of two arms has five processes and the launcher; the rest is for tools and dead nodes.
pub(crate) const MAX_NODES: usize = 32;
/// A reader keeps the last good message while it looks at the next.
// One borrowed message would have to be returned first, and a damaged newer one would then
// leave the reader without any.
pub(crate) const MAX_BORROWED: usize = 2;
/// Newest messages a late joiner gets of most topics.
// Two, as the newest may be of a tick that a gate keeps back: then the one before it counts.
pub(crate) const HISTORY: usize = 2;
/// Pieces of the largest state: lockstep waits for a recorder until it has the first
/// state, which was sent before it joined.
const STATE_PIECES: usize = MAX_OBJECTS.div_ceil(PIECE_OBJECTS);
/// Readers of a topic of few messages: the processes of a cell and tools.
// A joining tool is refused beyond this; the loops of the cell are not affected.
const MAX_SUBSCRIBERS: usize = 16;
/// Readers of a topic of many messages that no recorder needs whole: the launcher's tools
/// that show a running behaviour, and the page.
// A deep buffer is memory times readers.
const MAX_DEEP_SUBSCRIBERS: usize = 6;
/// Readers of a tap: the recorder, one that was killed, and one more.
// A tap has a second of messages or more, so each further reader costs as much as the topic.
const MAX_TAP_SUBSCRIBERS: usize = 3;
/// Loans of one publisher at a time.
// A message and its copy for the tap are loans of two ports; the second is slack.
const MAX_LOANED: usize = 2;

/// Newest messages of a topic that a late joiner gets: at most as many as a reader can
/// be behind.
pub(crate) fn history(topic: TopicId) -> usize {
    match topic {
        // Fewer than all pieces, and a recorder that joins late
        // waits for a state that is never complete.
        TopicId::WorldTap => STATE_PIECES,
        _ => HISTORY.min(topic.depth()),
    }
}

/// Readers of a topic.
pub(crate) fn max_subscribers(topic: TopicId) -> usize {
    match topic {
        _ if topic.is_tap() => MAX_TAP_SUBSCRIBERS,
        _ if topic.depth() > HISTORY => MAX_DEEP_SUBSCRIBERS,
        _ => MAX_SUBSCRIBERS,
    }
}

/// All topics of a cell of `arms` arms.
pub(crate) fn topics(arms: u8) -> Vec<TopicId> {
    let mut topics = vec![TopicId::WorldState, TopicId::Decision, TopicId::Trace];
    for arm in 0..arms {
        topics.extend([TopicId::ArmCommand(arm), TopicId::ArmStatus(arm)]);
    }
    topics.extend(Process::all(arms).into_iter().map(TopicId::Health));
    let taps: Vec<TopicId> = topics.iter().filter_map(|topic| topic.tap()).collect();
    topics.extend(taps);
    topics.extend([
        // Order is that of creation only; nothing may depend on it.
        TopicId::Contacts,
        TopicId::WorldTap,
        TopicId::Recorder,
        TopicId::Keyframe(Process::Task),
    ]);
    for arm in 0..arms {
        topics.extend([
            TopicId::Keyframe(Process::Controller(arm)),
            TopicId::ClientTap(arm),
        ]);
    }
    topics
}

fn message_size(topic: TopicId) -> usize {
    match topic {
        TopicId::WorldState => size_of::<WorldState>(),
        TopicId::Contacts => size_of::<Contacts>(),
        TopicId::WorldTap => size_of::<WorldPiece>(),
        TopicId::Keyframe(_) => size_of::<Keyframe>(),
        TopicId::ClientTap(_) => size_of::<ClientInput>(),
        TopicId::ArmCommand(_) | TopicId::ArmCommandTap(_) => size_of::<ArmCommand>(),
        TopicId::ArmStatus(_) | TopicId::ArmStatusTap(_) => size_of::<ArmStatus>(),
        TopicId::Decision | TopicId::DecisionTap => size_of::<Decision>(),
        TopicId::Trace => size_of::<TraceLine>(),
        TopicId::Health(_) | TopicId::Recorder => size_of::<Health>(),
    }
}

/// Messages a publisher's segment has room for: what all readers can hold and
/// have waiting, the history and the loans.
// Must mirror what the transport reserves. Too small, and the check before a start passes for a
// cell that dies of SIGBUS.
fn segment_messages(topic: TopicId) -> usize {
    max_subscribers(topic) * (topic.depth() + MAX_BORROWED) + history(topic) + MAX_LOANED
}

/// Shared memory a cell of `arms` arms needs, in bytes: two publishers per
/// topic (one may still be dead), and room for the transport's own records.
pub fn needed_bytes(arms: u8) -> u64 {
    // Bookkeeping of services, connections and the operator's service: 4 MiB
    // is twice of what a full cell was seen to take.
    const BOOKKEEPING: u64 = 4 << 20;
    // Allowance for the header of the transport before each message.
    const PER_MESSAGE: usize = 128;
    // Twice: a killed writer's segment stays until its node is
    // cleaned, beside that of its successor.
    let segments = topics(arms)
        .into_iter()
        .map(|topic| 2 * (segment_messages(topic) * (message_size(topic) + PER_MESSAGE)) as u64);
    segments.sum::<u64>() + BOOKKEEPING
}
