//! Messages of clients and other processes.

use cell_model::cells::script;
use ipc_types::{
    ArmCommand, ArmStatus, ClientInput, Decision, Health, Keyframe, OperatorReply, OperatorRequest,
    Pose, TraceLine, Validate, Wire, WorldPiece, WorldState,
};
use monitor_proc::page::command::{self, Names};

use policy_client::codec::{self, Convention};

use super::Target;

pub(crate) const SCRIPT: Target = Target {
    name: "script",
    run: |bytes| {
        let _read = script::parse(&String::from_utf8_lossy(bytes), "fuzzed.jsonl").is_ok();
    },
    corpus: || {
        let lines = [
            r#"{"at_s": 12.0, "do": "drag", "object": "blue_cube", "to": [0.5, -0.2, 0.025]}"#,
            r#"{"at_phase": "LIFT", "nth": 2, "after_s": 0.5, "do": "kill", "process": "task"}"#,
            r#"{"at_s": 3, "do": "stop", "process": "physics", "for_s": 1}"#,
            r#"{"at_s": 4, "do": "target", "position": [0.3, 0, 0.4], "orientation_wxyz": [0, 1, 0, 0]}"#,
            r#"{"at_s": 5, "do": "gripper", "to": "close", "arm": 1}"#,
            r#"{"at_s": 6, "do": "drop_parts", "count": 3}"#,
            r#"{"at_s": 6, "do": "add_bin", "flipped": true}"#,
            r#"{"at_s": 7, "do": "task_pause"}"#,
        ];
        vec![lines.join("\n").into_bytes()]
    },
};

pub(crate) const COMMAND: Target = Target {
    name: "command",
    run: |bytes| {
        let Ok(value) = serde_json::from_slice(bytes) else {
            return;
        };
        let names = Names {
            objects: vec!["red_cube".to_owned(), "blue_cube".to_owned()],
            arms: 2,
        };
        let _number = command::id(&value);
        let _read = command::parse(&value, &names).is_ok();
    },
    corpus: || {
        let commands = [
            r#"{"id": 1, "do": "pause"}"#,
            r#"{"id": 2, "do": "step", "count": 10}"#,
            r#"{"id": 3, "do": "drag", "object": "red_cube", "to": [0.5, 0.1, 0.2]}"#,
            r#"{"id": 4, "do": "target", "arm": 0, "position": [0.5, 0, 0.3], "orientation": [1, 0, 0, 0]}"#,
            r#"{"id": 5, "do": "gripper", "arm": 0, "to": "open"}"#,
            r#"{"id": 6, "do": "restart", "process": "task", "policy": "bt"}"#,
            r#"{"id": 7, "do": "load", "demo": "franka-stack", "seed": 3, "speed": "max"}"#,
            r#"{"id": 8, "do": "record", "what": "last", "seconds": 60}"#,
            r#"{"id": 9, "do": "seek", "to": 3.5, "play": true, "speed": 0.5}"#,
        ];
        commands.map(|text| text.as_bytes().to_vec()).to_vec()
    },
};

/// Answers of policy servers.
pub(crate) const POLICY_ANSWER: Target = Target {
    name: "policy_answer",
    run: |bytes| {
        let _is_hello = codec::is_hello(bytes);
        for convention in [Convention::OpenPi, Convention::VlaEval] {
            if let Ok(rows) = codec::actions(convention, bytes) {
                let width = rows.first().map_or(0, Vec::len);
                assert!(width > 0 && rows.iter().all(|row| row.len() == width));
                assert!(rows.iter().flatten().all(|number| number.is_finite()));
            }
        }
    },
    corpus: || {
        // {"actions": a 2 x 4 array of float32}, with keys of text and of bytes.
        let array = |key: u8| {
            let name = |text: &str| {
                let length = u8::try_from(text.len()).expect("a short name");
                match key {
                    0 => [&[0xa0 + length], text.as_bytes()].concat(),
                    _ => [&[0xc4, length], text.as_bytes()].concat(),
                }
            };
            let data = [&[0xc4, 32][..], &[0; 32]].concat();
            [
                vec![0x84],
                [name("__ndarray__"), vec![0xc3]].concat(),
                [name("data"), data].concat(),
                [name("dtype"), b"\xa3<f4".to_vec()].concat(),
                [name("shape"), vec![0x92, 2, 4]].concat(),
            ]
            .concat()
        };
        let actions = |array: Vec<u8>| [b"\x81\xa7actions".to_vec(), array].concat();
        let list = [b"\x81\xa7actions\x91\x94".to_vec(), vec![1, 2, 3, 0]].concat();
        let message = [
            b"\x84\xa4type\xa6action\xa3seq\x01\xa9timestamp\x00\xa7payload".to_vec(),
            actions(array(0)),
        ];
        let error = b"\x82\xa4type\xa5error\xa7payload\x81\xa7message\xa2no".to_vec();
        let hello = b"\x82\xa4type\xa5hello\xa7payload\x80".to_vec();
        vec![
            actions(array(0)),
            actions(array(1)),
            list,
            message.concat(),
            error,
            hello,
        ]
    },
};

/// The first byte selects the message.
pub(crate) const MESSAGE: Target = Target {
    name: "message",
    run: |bytes| {
        let Some((kind, bytes)) = bytes.split_first() else {
            return;
        };
        match kind % 11 {
            0 => judge::<WorldState>(bytes),
            1 => judge::<Decision>(bytes),
            2 => judge::<ArmCommand>(bytes),
            3 => judge::<ArmStatus>(bytes),
            4 => judge::<Health>(bytes),
            5 => judge::<OperatorRequest>(bytes),
            6 => judge::<OperatorReply>(bytes),
            7 => judge::<WorldPiece>(bytes),
            8 => judge::<Keyframe>(bytes),
            9 => judge::<ClientInput>(bytes),
            _ => judge::<TraceLine>(bytes),
        }
    },
    corpus: || {
        let mut command = ArmCommand::zeroed();
        command.joint_count = 7;
        let mut decision = Decision::zeroed();
        decision.arm_count = 1;
        decision.goals[0].target = Pose::IDENTITY;
        let request = OperatorRequest::zeroed_at_identity();
        vec![
            kind(0, WorldState::zeroed().as_bytes()),
            kind(1, decision.as_bytes()),
            kind(2, command.as_bytes()),
            kind(3, ArmStatus::zeroed().as_bytes()),
            kind(4, Health::zeroed().as_bytes()),
            kind(5, request.as_bytes()),
            kind(6, OperatorReply::zeroed().as_bytes()),
            kind(7, WorldPiece::zeroed().as_bytes()),
            kind(9, ClientInput::zeroed().as_bytes()),
            kind(10, TraceLine::zeroed().as_bytes()),
        ]
    },
};

fn kind(kind: u8, bytes: &[u8]) -> Vec<u8> {
    [&[kind], bytes].concat()
}

/// Bytes beyond the message are cut off, missing ones are zeros.
fn judge<T: Wire + Validate + core::fmt::Debug>(bytes: &[u8]) {
    let mut whole = vec![0; size_of::<T>()];
    let length = bytes.len().min(whole.len());
    whole[..length].copy_from_slice(&bytes[..length]);
    let Some(message) = T::from_bytes(&whole) else {
        return;
    };
    match message.validate() {
        Err(invalid) => drop(invalid.to_string()),
        Ok(()) => drop(format!("{message:?}")),
    }
}
