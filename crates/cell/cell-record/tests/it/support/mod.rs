//! A cell that publishes in every tick.

#![allow(dead_code, reason = "each test uses its own part")]

use cell_record::{Channel, Message, Preamble, wire_bytes};
use cell_run::spec::{RecordSpec, RunSpec, Speed};
use ipc_types::tap::Pieces;
use ipc_types::topic::Process;
use ipc_types::trace::TraceKind;
use ipc_types::world::{OBJECT_ENABLED, OBJECT_TOUCHED};
use ipc_types::{ArmCommand, ArmStatus, Decision, Header, Keyframe, Text, TraceLine};
use ipc_types::{Pose, Wire, WorldPiece, WorldState};
use serde_json::{Value, json};

pub(crate) fn run() -> RunSpec {
    RunSpec {
        contract: String::new(),
        run: 77,
        cell: "one".into(),
        demo: "franka-stack".into(),
        command: String::new(),
        policy: "fsm".into(),
        seed: 3,
        bins: None,
        set: Vec::new(),
        replace: Vec::new(),
        speed: Speed::RealTime,
        data_dir: None,
        task_program: None,
        controller_programs: Vec::new(),
        fci: Vec::new(),
        built_in_dir: std::path::PathBuf::new(),
        run_dir: "run".into(),
        root: "run/root".into(),
        prefix: "p".into(),
        arms: 1,
        robot: None,
        script: Vec::new(),
        paused: false,
        action_hz: None,
        frame_hash: Vec::new(),
        policy_server: None,
        until_done: false,
        time_limit_s: None,
        real_time: false,
        page: None,
        record: RecordSpec::default(),
        warnings: Vec::new(),
        incidents_dir: std::path::PathBuf::new(),
    }
}

pub(crate) fn scene() -> Value {
    let base = json!({ "position": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0] });
    json!({
        "arms": [{ "name": "arm", "base": base, "joints": [{ "name": "j1" }] }],
        "objects": [{ "name": "</script>", "shape": { "kind": "box", "size_m": [1, 2, 3] } }],
        "fixtures": [],
    })
}

pub(crate) fn preamble() -> Preamble {
    Preamble::new(&run(), &scene())
}

pub(crate) fn state(tick: u64) -> WorldState {
    let mut state = WorldState::zeroed();
    state.header = Header::caused_by::<WorldState>(tick);
    state.header.seq = tick;
    (state.arm_count, state.object_count) = (1, 20);
    state.arms[0].joint_positions[0] = tick as f64 * 1.0e-3;
    state.arms[0].joint_count = 7;
    state.arms[0].tcp = Pose::IDENTITY;
    for object in state.objects.iter_mut().take(20) {
        object.flags = OBJECT_ENABLED;
        object.pose = Pose::IDENTITY;
    }
    state.objects[3].flags |= OBJECT_TOUCHED;
    state.objects[3].pose.position[0] = tick as f64 * 1.0e-3;
    // Resting objects are in every tenth tick.
    state.objects[4].pose.position[0] = (tick / 10) as f64 * 1.0e-3;
    state
}

/// Passes all messages of `tick` to `say`.
pub(crate) fn tick(tick: u64, mut say: impl FnMut(&Message<'_>)) {
    let mut put = |channel, header: &Header, bytes: &[u8]| {
        say(&Message {
            channel,
            time_ns: header.sim_time_ns,
            publish_ns: 5 + header.sim_time_ns,
            seq: header.tick,
            bytes,
        });
    };
    let state = state(tick);
    let (mut pieces, mut piece) = (Pieces::of(&state, &[]), WorldPiece::zeroed());
    while pieces.write_next(&state, &mut piece) {
        put(Channel::World, &piece.header, wire_bytes(&piece));
    }
    let mut command = ArmCommand::zeroed();
    command.header = Header::caused_by::<ArmCommand>(tick);
    put(Channel::Command(0), &command.header, wire_bytes(&command));
    let mut status = ArmStatus::zeroed();
    status.header = Header::caused_by::<ArmStatus>(tick);
    status.cycles = tick;
    (status.setpoint, status.target) = (Pose::IDENTITY, Pose::IDENTITY);
    put(Channel::Status(0), &status.header, wire_bytes(&status));
    if tick.is_multiple_of(10) {
        let mut decision = Decision::zeroed();
        decision.header = Header::caused_by::<Decision>(tick);
        put(Channel::Decision, &decision.header, wire_bytes(&decision));
    }
    if tick.is_multiple_of(100) {
        let mut line = TraceLine::zeroed();
        line.header = Header::caused_by::<TraceLine>(tick);
        line.kind = TraceKind::Log.code();
        line.text = Text::new(&format!("line {tick}"));
        put(Channel::Log, &line.header, wire_bytes(&line));
    }
    if tick.is_multiple_of(1000) {
        let mut keyframe = Keyframe::zeroed();
        keyframe.header = Header::caused_by::<Keyframe>(tick);
        keyframe.set(&[7; 300], 0);
        let channel = Channel::Keyframe(Process::Task);
        put(channel, &keyframe.header, wire_bytes(&keyframe));
    }
}
