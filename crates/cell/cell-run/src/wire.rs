//! The messages between the processes as JSON, for programs in other languages.

use ipc_types::arm::{StopAction, StopCause};
use ipc_types::client::ClientEvent;
use ipc_types::contact::BodyKind;
use ipc_types::decision::{GoalKind, GripperGoal, Outcome};
use ipc_types::equipment::{BreakCause, BreakLimit, SuctionRefusal, SupplyRefusal};
use ipc_types::health::Scheduling;
use ipc_types::layout::{FieldLayout, StructLayout};
use ipc_types::layout_of;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::{TraceEvent, TraceKind};
use ipc_types::world::PauseCause;
use ipc_types::{
    ArmCommand, ArmStatus, ClientInput, Contacts, DECISION_TICKS, Decision, Health, Keyframe,
    MAX_ARMS, MAX_BREAKS, MAX_INPUTS, MAX_JOINTS, MAX_OBJECTS, OperatorReply, OperatorRequest,
    TICK_NS, TraceLine, Wire, WorldPiece, WorldState,
};
use serde_json::{Map, Value, json};

/// All structs, codes and constants of the wire, and the message of each topic: `{"version",
/// "contract", "byte_order", "constants": {NAME: number}, "codes": {TYPE: {NAME: number}},
/// "topics": {SERVICE: MESSAGE}, "structs": {NAME: {"size", "schema", "fields": [{"name",
/// "type", "count", "offset"}]}}}`. `schema` has 16 hexadecimal digits; the name of a message
/// in iceoryx2 is `NAME#SCHEMA`. Offsets are in bytes; there is no padding.
pub fn schema() -> Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "contract": contract(),
        "byte_order": "little",
        "constants": {
            "DECISION_TICKS": DECISION_TICKS,
            "MAX_ARMS": MAX_ARMS,
            "MAX_BREAKS": MAX_BREAKS,
            "MAX_INPUTS": MAX_INPUTS,
            "MAX_JOINTS": MAX_JOINTS,
            "MAX_OBJECTS": MAX_OBJECTS,
            "TICK_NS": TICK_NS,
        },
        "codes": codes(),
        "topics": topics(),
        "structs": structs(),
    })
}

/// The contract of the processes of one cell: the version of robocell, and a hash of all
/// messages. Programs with different contracts cannot communicate.
pub fn contract() -> String {
    const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;
    let messages = [
        WorldState::SCHEMA,
        Contacts::SCHEMA,
        ArmCommand::SCHEMA,
        ArmStatus::SCHEMA,
        Decision::SCHEMA,
        TraceLine::SCHEMA,
        Health::SCHEMA,
        WorldPiece::SCHEMA,
        Keyframe::SCHEMA,
        ClientInput::SCHEMA,
        OperatorRequest::SCHEMA,
        OperatorReply::SCHEMA,
    ];
    let mix = |hash: u64, schema: u64| (hash ^ schema).wrapping_mul(FNV_PRIME);
    // A chain, not a sum: exchanging two messages changes the hash, too.
    let hash = messages.into_iter().fold(0, mix);
    format!("{} (messages {hash:016x})", env!("CARGO_PKG_VERSION"))
}

macro_rules! codes {
    ($($name:ident),* $(,)?) => {
        json!({ $(stringify!($name): named($name::CODES)),* })
    };
}

fn codes() -> Value {
    codes!(
        BodyKind,
        BreakCause,
        BreakLimit,
        ClientEvent,
        GoalKind,
        GripperGoal,
        OperatorAction,
        Outcome,
        PauseCause,
        ReplyCode,
        Scheduling,
        StopAction,
        StopCause,
        SuctionRefusal,
        SupplyRefusal,
        TraceEvent,
        TraceKind,
    )
}

fn named(codes: &[(&'static str, u32)]) -> Value {
    let named = codes
        .iter()
        .map(|(name, code)| ((*name).to_owned(), json!(code)));
    Value::Object(named.collect())
}

fn topics() -> Value {
    let mut topics = Map::new();
    let mut add = |topic: TopicId, message: &str| topics.insert(topic.service(), json!(message));
    add(TopicId::WorldState, "WorldState");
    add(TopicId::Contacts, "Contacts");
    add(TopicId::Decision, "Decision");
    add(TopicId::Trace, "TraceLine");
    add(TopicId::WorldTap, "WorldPiece");
    add(TopicId::DecisionTap, "Decision");
    add(TopicId::Recorder, "Health");
    let arms = u8::try_from(MAX_ARMS).unwrap_or(u8::MAX);
    for arm in 0..arms {
        add(TopicId::ArmCommand(arm), "ArmCommand");
        add(TopicId::ArmCommandTap(arm), "ArmCommand");
        add(TopicId::ArmStatus(arm), "ArmStatus");
        add(TopicId::ArmStatusTap(arm), "ArmStatus");
        add(TopicId::ClientTap(arm), "ClientInput");
    }
    for process in Process::all(arms) {
        add(TopicId::Health(process), "Health");
        add(TopicId::Keyframe(process), "Keyframe");
    }
    Value::Object(topics)
}

fn structs() -> Value {
    let mut all: Vec<StructLayout> = Vec::new();
    for layouts in [
        layout_of::<WorldState>(),
        layout_of::<Contacts>(),
        layout_of::<ArmCommand>(),
        layout_of::<ArmStatus>(),
        layout_of::<Decision>(),
        layout_of::<TraceLine>(),
        layout_of::<Health>(),
        layout_of::<WorldPiece>(),
        layout_of::<Keyframe>(),
        layout_of::<ClientInput>(),
        layout_of::<OperatorRequest>(),
        layout_of::<OperatorReply>(),
    ] {
        all.extend(layouts);
    }
    Value::Object(all.iter().map(described).collect())
}

fn described(layout: &StructLayout) -> (String, Value) {
    let fields: Vec<Value> = layout.fields.iter().map(field).collect();
    let value = json!({
        "size": layout.bytes,
        "schema": format!("{:016x}", layout.schema),
        "fields": fields,
    });
    (layout.name.to_owned(), value)
}

fn field(field: &FieldLayout) -> Value {
    json!({
        "name": field.name,
        "type": field.element,
        "count": field.count,
        "offset": field.offset,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_of_the_schema_finds_every_message_and_all_of_its_bytes() {
        let schema = schema();
        let structs = schema["structs"].as_object().unwrap();
        for (topic, message) in schema["topics"].as_object().unwrap() {
            assert!(structs.contains_key(message.as_str().unwrap()), "{topic}");
        }
        let size = |name: &str| match name {
            "u8" => 1,
            "u32" => 4,
            "u64" | "i64" | "f64" => 8,
            text if text.starts_with("Text") => text[4..].parse().unwrap(),
            name => structs[name]["size"].as_u64().unwrap(),
        };
        for (name, layout) in structs {
            let mut end = 0;
            for field in layout["fields"].as_array().unwrap() {
                assert_eq!(field["offset"].as_u64(), Some(end), "{name}: {field}");
                let count = field["count"].as_u64().unwrap();
                end += count * size(field["type"].as_str().unwrap());
            }
            assert_eq!(layout["size"].as_u64(), Some(end), "{name}");
        }
    }

    #[test]
    fn the_schema_names_the_codes_that_are_sent() {
        let schema = schema();
        let goal = &schema["codes"]["GoalKind"];
        assert_eq!(goal["Pose"], GoalKind::Pose.code());
        assert_eq!(schema["topics"]["health/controller-1"], "Health");
        let schema_of_state = format!("{:016x}", WorldState::SCHEMA);
        assert_eq!(schema["structs"]["WorldState"]["schema"], schema_of_state);
    }
}
