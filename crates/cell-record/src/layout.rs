//! What our own structs look like in memory, as JSON, so that a reader of any
//! language can take them apart.

use ipc_types::decision::{CellIo, MAX_PLACED};
use ipc_types::equipment::MAX_SENSORS;
use ipc_types::tap::{KEYFRAME_BYTES, PIECE_OBJECTS, PieceObject};
use ipc_types::{
    ArmCommand, ArmGoal, ArmState, ArmStatus, Decision, EquipmentState, GripperCommand,
    GripperState, Header, Input, Keyframe, MAX_ARMS, MAX_BREAKS, MAX_INPUTS, MAX_JOINTS,
    ObjectState, OperatorPanel, Pose, Text, TraceLine, Twist, WorldPiece,
};
use serde_json::{Map, Value, json};

/// `schema_encoding` of the channels of structs.
pub(crate) const ENCODING: &str = "robocell/layout";

type Text16 = Text<16>;
type Text32 = Text<32>;
type Text48 = Text<48>;
type Text160 = Text<160>;

/// Describes structs: the offsets come from the compiler, and a field that is
/// left out, or of another size, does not compile.
macro_rules! layouts {
    ($($name:ident { $($field:ident: $type:ident $([$count:expr])?,)* })*) => {
        fn define(name: &str, into: &mut Map<String, Value>) {
            if into.contains_key(name) {
                return;
            }
            match name {
                $(stringify!($name) => {
                    const _: () = assert!(
                        0 $(+ size_of::<$type>() $(* $count)?)* == size_of::<$name>()
                    );
                    let fields = json!([$({
                        "name": stringify!($field),
                        "type": stringify!($type),
                        "offset": core::mem::offset_of!($name, $field),
                        "count": 1 $(* $count)?,
                    }),*]);
                    let size = size_of::<$name>();
                    into.insert(name.to_owned(), json!({ "size": size, "fields": fields }));
                    $(define(stringify!($type), into);)*
                })*
                _ => {}
            }
        }
    };
}
layouts! {
    Header {
        schema: u64,
        run: u64,
        generation: u32,
        input_count: u32,
        seq: u64,
        tick: u64,
        sim_time_ns: u64,
        publish_ns: u64,
        inputs: Input [MAX_INPUTS],
    }
    Input {
        topic: u32,
        generation: u32,
        seq: u64,
        age_ticks: u64,
    }
    Pose {
        position: f64 [3],
        orientation_wxyz: f64 [4],
    }
    Twist {
        linear: f64 [3],
        angular: f64 [3],
    }
    GripperState {
        width: f64,
        width_velocity: f64,
        grip_force: f64,
        load: f64,
        suction_force: f64,
        suction_torque: f64,
        peak_force: f64,
        peak_torque: f64,
        attached: u32,
        held_object: u32,
        beam_object: u32,
        suction: u32,
        refusals: u32,
        refusal: u32,
        breaks: u32,
        break_limit: u32,
        break_cause: u32,
        reserved: u32,
    }
    ArmState {
        joint_count: u32,
        stop_action: u32,
        joint_positions: f64 [MAX_JOINTS],
        joint_velocities: f64 [MAX_JOINTS],
        joint_efforts: f64 [MAX_JOINTS],
        setpoint_positions: f64 [MAX_JOINTS],
        setpoint_velocities: f64 [MAX_JOINTS],
        setpoint_accelerations: f64 [MAX_JOINTS],
        tcp: Pose,
        gripper: GripperState,
        command_seq: u64,
        command_tick: u64,
        command_generation: u32,
        fault: u32,
        limit_violations: u64,
    }
    ObjectState {
        flags: u32,
        reserved: u32,
        pose: Pose,
        twist: Twist,
    }
    OperatorPanel {
        task_start: u32,
        task_started: u32,
        pause_cause: u32,
        task_reset: u32,
        task_paused: u32,
        target_arm: u32,
        target_seq: u32,
        gripper_seq: u32,
        gripper: u32,
        drop_parts: u32,
        add_bin: u32,
        scene_reset: u32,
        target_is_joints: u32,
        break_count: u32,
        target: Pose,
        target_joints: f64 [MAX_JOINTS],
        speed: f64,
        breaks: Text48 [MAX_BREAKS],
    }
    PieceObject {
        index: u32,
        reserved: u32,
        state: ObjectState,
    }
    EquipmentState {
        conveyor_speed: f64,
        bins_supplied: u32,
        supply_refusals: u32,
        supply_refusal: u32,
        parts_dropped: u32,
        parts_waiting: u32,
        cleared: u32,
        sensors: u32 [MAX_SENSORS],
    }
    WorldPiece {
        header: Header,
        state: Header,
        piece: u32,
        pieces: u32,
        flags: u32,
        arm_count: u32,
        object_count: u32,
        script_line: u32,
        script_left: u32,
        quarantined: u32,
        overruns: u64,
        state_hash: u64,
        panel: OperatorPanel,
        equipment: EquipmentState,
        arms: ArmState [MAX_ARMS],
        all_objects: u32,
        count: u32,
        objects: PieceObject [PIECE_OBJECTS],
    }
    GripperCommand {
        width: f64,
        force: f64,
        suction: u32,
        reserved: u32,
    }
    ArmCommand {
        header: Header,
        arm: u32,
        joint_count: u32,
        joint_positions: f64 [MAX_JOINTS],
        joint_velocities: f64 [MAX_JOINTS],
        joint_accelerations: f64 [MAX_JOINTS],
        joint_efforts: f64 [MAX_JOINTS],
        gripper: GripperCommand,
    }
    ArmStatus {
        header: Header,
        arm: u32,
        stop_action: u32,
        stop_cause: u32,
        goal_active: u32,
        goal_generation: u32,
        selector: u32,
        goal_id: u64,
        decision_tick: u64,
        decision_age_ticks: u64,
        position_error: f64,
        orientation_error: f64,
        gripper_error: f64,
        setpoint: Pose,
        target: Pose,
        min_clearance: f64,
        clipped_joints: u64,
        clipped_cycles: u64,
        cycles: u64,
        missed_cycles: u64,
        gripper: GripperCommand,
        controller: Text32,
    }
    ArmGoal {
        goal_id: u64,
        kind: u32,
        gripper: u32,
        selector: u32,
        has_posture: u32,
        target: Pose,
        posture: f64 [MAX_JOINTS],
        grip_force: f64,
        approach: f64 [3],
        approach_std_dev: f64,
        obstacle_mask: u64,
        object_mask: u64,
    }
    CellIo {
        conveyor_running: u32,
        drop_parts: u32,
        add_bin: u32,
        reserved: u32,
    }
    Decision {
        header: Header,
        arm_count: u32,
        outcome: u32,
        goals: ArmGoal [MAX_ARMS],
        io: CellIo,
        phase: Text32,
        policy: Text16,
        reason: Text48,
        phase_entry: u32,
        drops: u32,
        resyncs: u32,
        aborts: u32,
        recoveries: u32,
        placed_count: u32,
        placed: u32 [MAX_PLACED],
        break_tick: u64,
        break_name: Text48,
    }
    TraceLine {
        header: Header,
        kind: u32,
        graph: u32,
        node: u32,
        from: u32,
        to: u32,
        event: u32,
        text: Text160,
    }
    Keyframe {
        header: Header,
        after_seq: u64,
        len: u32,
        reserved: u32,
        bytes: u8 [KEYFRAME_BYTES],
    }
}

/// The layout of `name` and of every struct in it: `{"root", "byte_order",
/// "structs": {NAME: {"size", "fields": [{"name", "type", "offset", "count"}]}}}`.
pub(crate) fn of(name: &str) -> String {
    let mut structs = Map::new();
    define(name, &mut structs);
    json!({ "root": name, "byte_order": "little", "structs": structs }).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    #[test]
    fn a_reader_that_knows_nothing_else_finds_a_joint_of_a_piece() {
        let mut piece = WorldPiece::zeroed();
        piece.arms[1].joint_velocities[2] = 0.25;
        let layout: Value = serde_json::from_str(&of("WorldPiece")).unwrap();
        let offset = |of: &str, field: &str| {
            let fields = layout["structs"][of]["fields"].as_array().unwrap();
            let field = fields.iter().find(|f| f["name"] == field).unwrap();
            field["offset"].as_u64().unwrap() as usize
        };
        let arm_bytes = layout["structs"]["ArmState"]["size"].as_u64().unwrap() as usize;
        let at = offset("WorldPiece", "arms")
            + arm_bytes
            + offset("ArmState", "joint_velocities")
            + 2 * 8;
        let bytes = piece.as_bytes()[at..at + 8].try_into().unwrap();
        assert_eq!(f64::from_le_bytes(bytes), 0.25);
    }
}
