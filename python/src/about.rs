//! The description of a cell that Python gets before it runs, as JSON.

use cell_model::Cell;
use cell_run::wire;
use pyo3::prelude::*;
use robocell_skills::Setup;
use serde_json::{Value, json};

/// Names and numbers of a cell: its `[task]` table, and its arms, objects, sensors,
/// obstacles and places in the order of the file.
pub(crate) fn cell(cell: &Cell, setup: &Setup, settings: &Value) -> String {
    let arms: Vec<Value> = cell.arms.iter().zip(&setup.arms).map(arm).collect();
    let objects: Vec<Value> = setup
        .objects
        .iter()
        .map(|object| json!({ "name": object.name, "half_height_m": object.half_height_m }))
        .collect();
    json!({
        "name": cell.name,
        "task": settings,
        "arms": arms,
        "objects": objects,
        "sensors": setup.sensors,
        "obstacles": setup.obstacles,
        "time_limit_s": cell.time_limit_s,
    })
    .to_string()
}

fn arm((spec, setup): (&cell_model::ArmSpec, &robocell_skills::ArmSetup)) -> Value {
    let joints = spec.robot.chain.joints();
    let named = spec.robot.arm_joints.iter().filter_map(|i| joints.get(*i));
    let names: Vec<&str> = named.map(|joint| joint.name.as_str()).collect();
    let base: [f64; 3] = setup.base.into();
    json!({
        "name": setup.name,
        "robot": spec.robot.name,
        "joint_names": names,
        "home_position": setup.wait.position,
        "home_orientation": setup.wait.orientation_wxyz,
        "home": &setup.home[..names.len().min(setup.home.len())],
        "base_position_m": base,
        "reach_m": setup.reach_m,
    })
}

/// Layouts, codes and topics of the messages between the processes, as JSON: what
/// `robocell schema wire` prints.
#[pyfunction]
pub(crate) fn wire_schema() -> String {
    wire::schema().to_string()
}
