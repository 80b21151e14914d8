//! Codes of enums and topics: recordings and programs in other languages keep them, so a code
//! is never given to another value.

use std::collections::BTreeSet;

use ipc_types::arm::{DriveMode, NotReached, PlanState, StopAction, StopCause};
use ipc_types::client::ClientEvent;
use ipc_types::contact::BodyKind;
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::equipment::{BreakCause, BreakLimit, SuctionRefusal, SupplyRefusal};
use ipc_types::health::Scheduling;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::{TraceEvent, TraceKind};
use ipc_types::world::PauseCause;
use ipc_types::{GripperGoal, MAX_ARMS};

/// The codes of an enum as one line; each of them and no other is taken.
macro_rules! line {
    ($name:ident) => {{
        let codes = $name::CODES.iter();
        let line: Vec<String> = codes.map(|(name, code)| format!("{name} {code}")).collect();
        for code in 0..64 {
            let known = $name::CODES.iter().any(|(_, known)| *known == code);
            let found = $name::from_code(code).map($name::code);
            assert_eq!(found, known.then_some(code), "{}", stringify!($name));
        }
        format!("{}: {}", stringify!($name), line.join(", "))
    }};
}

#[test]
fn the_codes_of_all_values_are_the_published_ones() {
    let codes = [
        line!(BodyKind),
        line!(BreakCause),
        line!(BreakLimit),
        line!(ClientEvent),
        line!(DriveMode),
        line!(GoalKind),
        line!(GripperGoal),
        line!(NotReached),
        line!(OperatorAction),
        line!(Outcome),
        line!(PauseCause),
        line!(PlanState),
        line!(ReplyCode),
        line!(Scheduling),
        line!(StopAction),
        line!(StopCause),
        line!(SuctionRefusal),
        line!(SupplyRefusal),
        line!(TraceEvent),
        line!(TraceKind),
    ];
    let published = include_str!("../codes.txt").lines();
    for (is, was) in codes.iter().zip(published.clone()) {
        assert_eq!(is, was, "ipc-types/tests/codes.txt");
    }
    assert_eq!(codes.len(), published.count());
}

/// All topics of a cell with as many arms as there can be.
fn topics() -> Vec<TopicId> {
    let mut all = vec![
        TopicId::WorldState,
        TopicId::Decision,
        TopicId::Trace,
        TopicId::WorldTap,
        TopicId::DecisionTap,
        TopicId::Recorder,
        TopicId::Contacts,
    ];
    let arms = u8::try_from(MAX_ARMS).unwrap();
    for arm in 0..arms {
        all.extend([
            TopicId::ArmCommand(arm),
            TopicId::ArmStatus(arm),
            TopicId::ArmCommandTap(arm),
            TopicId::ArmStatusTap(arm),
            TopicId::ClientTap(arm),
        ]);
    }
    for process in Process::all(arms) {
        all.extend([TopicId::Health(process), TopicId::Keyframe(process)]);
    }
    all
}

#[test]
fn each_topic_has_a_code_and_a_name_of_its_own() {
    let topics = topics();
    let codes: BTreeSet<u32> = topics.iter().map(|topic| topic.code()).collect();
    let names: BTreeSet<String> = topics.iter().map(|topic| topic.service()).collect();
    assert_eq!((codes.len(), names.len()), (topics.len(), topics.len()));
    assert!(!codes.contains(&0), "0 marks an input that is not used");
    let fixed: Vec<u32> = topics.iter().take(7).map(|topic| topic.code()).collect();
    assert_eq!(fixed, [1, 2, 3, 4, 5, 6, 7]);
    let of_arm = [
        (TopicId::ArmCommand(1), 0x101, "arm/1/command"),
        (TopicId::ArmStatus(1), 0x201, "arm/1/status"),
        (TopicId::ArmCommandTap(1), 0x401, "tap/arm/1/command"),
        (TopicId::ArmStatusTap(1), 0x501, "tap/arm/1/status"),
        (TopicId::Health(Process::Monitor), 0x302, "health/monitor"),
        (
            TopicId::Health(Process::Controller(1)),
            0x311,
            "health/controller-1",
        ),
        (TopicId::ClientTap(1), 0x701, "tap/fci/1"),
        (TopicId::Keyframe(Process::Task), 0x601, "tap/keyframe/task"),
    ];
    for (topic, code, name) in of_arm {
        assert_eq!((topic.code(), topic.service().as_str()), (code, name));
    }
}

#[test]
fn a_copy_for_the_recorder_waits_longer_than_the_message_itself() {
    for topic in topics() {
        let Some(tap) = topic.tap() else { continue };
        assert!(tap.is_tap() && !topic.is_tap(), "{topic:?}");
        assert!(tap.depth() >= 100 * topic.depth(), "{topic:?}");
        assert_eq!(tap.tap(), None, "{topic:?}: a copy has no copy");
    }
}

#[test]
fn physics_starts_first_and_the_monitor_last() {
    let names: Vec<String> = Process::all(2).into_iter().map(Process::name).collect();
    let order = ["physics", "controller-0", "controller-1", "task", "monitor"];
    assert_eq!(names, order);
}
