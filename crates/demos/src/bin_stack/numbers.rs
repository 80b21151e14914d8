//! `[task]` with `kind = "bin_stack"`.

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Cell, Checker, ModelError, Shape};
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check;

/// Bins off a conveyor into columns, all of them upside down. Places of the tool
/// are those of the cup's end, world frame.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinStackTask {
    /// File in `cells/` that describes the behaviour.
    pub behaviour: String,
    /// `name` of the bins' table.
    pub bins: String,
    /// Sensor that sees a bin at the end of the belt.
    pub sensor: String,
    /// Where the arm waits (m).
    pub rest_position_m: [f64; 3],
    /// How it waits, w x y z.
    pub rest_orientation_wxyz: [f64; 4],
    /// Direction of the arm's plane above the belt, about z (rad).
    pub belt_yaw_rad: f64,
    /// Half the belt's end along x and y, around the bin that waits (m): while a
    /// bin is in there the belt stands.
    pub belt_end_m: [f64; 2],
    /// Centre of that, on the belt (m).
    pub belt_end_position_m: [f64; 3],
    /// Between belt and columns (m).
    pub via_position_m: [f64; 3],
    /// Direction of the arm's plane there, about z (rad).
    pub via_yaw_rad: f64,
    /// Height at which bins travel (m).
    pub carry_height_m: f64,
    /// Tool above the surface it is going to touch (m).
    pub hover_m: f64,
    /// Air that is left between cup and surface when suction is switched on (m).
    pub touch_gap_m: f64,
    /// Air that is left below a bin when it is let go (m).
    pub place_gap_m: f64,
    /// Pace of the tool on its long ways (m/s).
    pub speed_m_s: f64,
    /// And where it is about to touch, or to let go (m/s).
    pub slow_speed_m_s: f64,
    /// Pace at which it turns (rad/s).
    pub turn_speed_rad_s: f64,
    /// Columns and levels.
    pub stack: BinColumns,
    /// Where bins are turned over.
    pub station: FlippingStation,
    /// A bin comes that many steps of 1/60 s after a pick: least and most.
    pub next_bin_steps: [u32; 2],
    /// Time a state may last (s).
    pub state_timeout_s: f64,
    /// Time suction may take to attach a bin, or to let go (s).
    pub suction_timeout_s: f64,
    /// Pick-ups or set-downs of one bin that may fail in a row.
    pub max_attempts: u32,
}

/// `[task.stack]`: nine columns.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinColumns {
    /// Centre of column (0, 0) on its support (m).
    pub first_m: [f64; 3],
    /// To the next column of the first index, x and y (m).
    pub first_step_m: [f64; 2],
    /// To the next column of the second index, x and y (m).
    pub second_step_m: [f64; 2],
    /// Turn of the bins about z (rad).
    pub bin_yaw_rad: f64,
    /// Direction of the arm's plane above them, about z (rad).
    pub tool_yaw_rad: f64,
    /// Bins of one column.
    pub levels: u32,
    /// A bin nearer than this to the axis of its column is in place (m).
    pub tolerance_m: f64,
    /// And nearer than this to the height of its level (m).
    pub height_tolerance_m: f64,
}

/// `[task.station]`: a holder of rails for the rim of a bin, open towards the
/// arm; the tool holds the bin from below.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlippingStation {
    /// Middle between the rails, on their upper face (m).
    pub position_m: [f64; 3],
    /// Direction in which bins slide in, about z (rad); away from the arm.
    pub yaw_rad: f64,
    /// Distance from which they slide in (m).
    pub slide_m: f64,
    /// Height above the rails at which they do (m).
    pub lift_m: f64,
    /// How far the tool is pushed down out of a bin (m).
    pub push_down_m: f64,
    /// Height above the rails of the axis it is turned over about (m).
    pub turn_height_m: f64,
    /// Distance of the cup from that axis (m).
    pub turn_radius_m: f64,
    /// Joints with the cup pointing down before it is turned over, and up
    /// afterwards: at the slide's distance from the holder, on both sides of the
    /// axis (rad).
    pub down_joint_positions: [f64; 6],
    /// See `down_joint_positions` (rad).
    pub up_joint_positions: [f64; 6],
    /// Waypoints (of 1/60 s) the arm waits before it lets go.
    pub wait_steps: u32,
}

impl Settings for BinStackTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        check::behaviour(at, &self.behaviour)?;
        bin_table(at, self, cell)?;
        sensor_of(at, self, cell)?;
        for (key, position) in [
            ("task.rest_position_m", &self.rest_position_m),
            ("task.belt_end_position_m", &self.belt_end_position_m),
            ("task.via_position_m", &self.via_position_m),
            ("task.stack.first_m", &self.stack.first_m),
            ("task.station.position_m", &self.station.position_m),
        ] {
            at.position(key, position)?;
        }
        let orientation = &self.rest_orientation_wxyz;
        check::unit_quaternion(at, "task.rest_orientation_wxyz", orientation, 1.0e-3)?;
        bin_numbers(at, self)?;
        columns(at, &self.stack)?;
        station(at, &self.station)
    }
}

fn bin_table(at: &Checker<'_>, task: &BinStackTask, cell: &Cell) -> Result<(), ModelError> {
    let bins = cell.objects.iter();
    let bins = bins.filter(|object| matches!(object.shape, Shape::Bin { .. }));
    let mut names: Vec<&str> = bins.map(|object| object.kind.as_str()).collect();
    names.dedup();
    let what = "[[object]] with the shape of a bin";
    check::known(at, "task.bins", &task.bins, what, &names)
}

fn sensor_of(at: &Checker<'_>, task: &BinStackTask, cell: &Cell) -> Result<(), ModelError> {
    let names: Vec<&str> = cell.sensors.iter().map(|s| s.name.as_str()).collect();
    check::known(at, "task.sensor", &task.sensor, "[[sensor]]", &names)
}

fn bin_numbers(at: &Checker<'_>, task: &BinStackTask) -> Result<(), ModelError> {
    let far = MAX_COORDINATE_M;
    at.numbers("task.belt_end_m", &task.belt_end_m, 0.01, far)?;
    for (key, value, low, high) in [
        ("task.belt_yaw_rad", task.belt_yaw_rad, -7.0, 7.0),
        ("task.via_yaw_rad", task.via_yaw_rad, -7.0, 7.0),
        ("task.carry_height_m", task.carry_height_m, -far, far),
        ("task.hover_m", task.hover_m, 0.0, 1.0),
        ("task.speed_m_s", task.speed_m_s, 0.001, 5.0),
        ("task.slow_speed_m_s", task.slow_speed_m_s, 0.001, 5.0),
        ("task.turn_speed_rad_s", task.turn_speed_rad_s, 0.001, 10.0),
        ("task.touch_gap_m", task.touch_gap_m, 0.0, 0.05),
        ("task.place_gap_m", task.place_gap_m, 0.0, 0.05),
        ("task.state_timeout_s", task.state_timeout_s, 0.1, 3600.0),
        (
            "task.suction_timeout_s",
            task.suction_timeout_s,
            0.02,
            3600.0,
        ),
    ] {
        at.number(key, value, low, high)?;
    }
    let attempts = f64::from(task.max_attempts);
    at.number("task.max_attempts", attempts, 1.0, 1000.0)?;
    let [least, most] = task.next_bin_steps.map(f64::from);
    at.number("task.next_bin_steps.1", most, least.max(1.0), 1.0e5)
}

fn columns(at: &Checker<'_>, stack: &BinColumns) -> Result<(), ModelError> {
    at.numbers("task.stack.first_step_m", &stack.first_step_m, -2.0, 2.0)?;
    at.numbers("task.stack.second_step_m", &stack.second_step_m, -2.0, 2.0)?;
    for (key, value, low, high) in [
        ("task.stack.bin_yaw_rad", stack.bin_yaw_rad, -7.0, 7.0),
        ("task.stack.tool_yaw_rad", stack.tool_yaw_rad, -7.0, 7.0),
        ("task.stack.levels", f64::from(stack.levels), 1.0, 5.0),
        ("task.stack.tolerance_m", stack.tolerance_m, 1.0e-4, 0.5),
        (
            "task.stack.height_tolerance_m",
            stack.height_tolerance_m,
            1.0e-4,
            0.5,
        ),
    ] {
        at.number(key, value, low, high)?;
    }
    Ok(())
}

fn station(at: &Checker<'_>, station: &FlippingStation) -> Result<(), ModelError> {
    for (key, joints) in [
        (
            "task.station.down_joint_positions",
            &station.down_joint_positions,
        ),
        (
            "task.station.up_joint_positions",
            &station.up_joint_positions,
        ),
    ] {
        at.numbers(key, joints, -7.0, 7.0)?;
    }
    for (key, value, low, high) in [
        ("task.station.yaw_rad", station.yaw_rad, -7.0, 7.0),
        ("task.station.slide_m", station.slide_m, 0.01, 2.0),
        ("task.station.lift_m", station.lift_m, 0.0, 1.0),
        ("task.station.push_down_m", station.push_down_m, 0.0, 1.0),
        (
            "task.station.turn_height_m",
            station.turn_height_m,
            -2.0,
            2.0,
        ),
        (
            "task.station.turn_radius_m",
            station.turn_radius_m,
            0.0,
            1.0,
        ),
        (
            "task.station.wait_steps",
            f64::from(station.wait_steps),
            0.0,
            6000.0,
        ),
    ] {
        at.number(key, value, low, high)?;
    }
    Ok(())
}
