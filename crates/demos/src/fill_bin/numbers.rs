//! `[task]` with `kind = "fill_bin"`.

use cell_model::{Cell, Checker, ModelError, Shape};
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check;

/// Hold a bin under the dispenser until the grip breaks, and find it again.
///
/// Positions are those of the world frame. Poses of the tool are those of its
/// TCP, whose x axis is the direction in which the cup points.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FillBinTask {
    /// File in `cells/` that describes the behaviour.
    pub behaviour: String,
    /// The bin: an object of the cell.
    pub bin: String,
    /// A fixture that stands close around the bin: no obstacle while it is
    /// picked up.
    #[serde(default)]
    pub stand: Option<String>,
    /// Where the cup rests between two picks (m).
    pub default_position_m: [f64; 3],
    /// Its orientation there, w x y z.
    pub default_orientation_wxyz: [f64; 4],
    /// Where the cup holds a bin that hangs on the inside of its floor (m).
    pub hold_position_m: [f64; 3],
    /// Turn of a held bin's long edge about the vertical axis (rad).
    pub hold_yaw_rad: f64,
    /// The way to the bin goes over a point this far above the surface that is
    /// gripped (m).
    pub above_m: f64,
    /// Gap between cup and surface when suction is switched on (m).
    pub gap_m: f64,
    /// A bin that hangs upside down is let fall this far beside the hold
    /// position, x, y and z, to lie otherwise afterwards (m).
    pub tip_over_m: [f64; 3],
    /// A bin is raised by this before it is carried (m),
    pub lift_m: f64,
    /// in this time (s),
    pub lift_s: f64,
    /// and carried in this (s).
    pub carry_s: f64,
    /// Time between two requests for parts (s).
    pub drop_interval_s: f64,
    /// Suction that holds nothing after this is switched off again (s).
    pub attach_s: f64,
    /// How far the cup backs off after two refusals in place (m).
    pub back_off_m: f64,
    /// A pick-up that takes longer in one state is given up (s).
    pub state_timeout_s: f64,
    /// Pick-ups of the same bin that fail in a row before the job is given up.
    pub max_attempts: u32,
    /// A surface that faces away from straight up by more than this cannot be
    /// gripped (rad).
    pub max_tilt_rad: f64,
    /// Distances from the arm's base, in the plane, between which a surface can
    /// be gripped (m).
    pub reach_m: [f64; 2],
    /// A bin that cannot be picked up for this long is given up (s).
    pub patience_s: f64,
}

impl Settings for FillBinTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        check::behaviour(at, &self.behaviour)?;
        let bins = cell.objects.iter();
        let bins = bins.filter(|o| matches!(o.shape, Shape::Bin { .. }) && o.name == o.kind);
        let bins: Vec<&str> = bins.map(|o| o.name.as_str()).collect();
        check::known(at, "task.bin", &self.bin, "bin", &bins)?;
        if let Some(stand) = &self.stand {
            let obstacles = cell.fixtures.iter().filter(|f| f.obstacle);
            let names: Vec<&str> = obstacles.map(|f| f.name.as_str()).collect();
            check::known(
                at,
                "task.stand",
                stand,
                "fixture with obstacle = true",
                &names,
            )?;
        }
        at.position("task.default_position_m", &self.default_position_m)?;
        at.position("task.hold_position_m", &self.hold_position_m)?;
        at.numbers("task.tip_over_m", &self.tip_over_m, -0.5, 0.5)?;
        let orientation = &self.default_orientation_wxyz;
        at.numbers("task.default_orientation_wxyz", orientation, -1.0, 1.0)?;
        check::unit_quaternion(at, "task.default_orientation_wxyz", orientation, 1.0e-3)?;
        fill_bin_numbers(at, self)
    }
}

fn fill_bin_numbers(at: &Checker<'_>, task: &FillBinTask) -> Result<(), ModelError> {
    let ranges = [
        ("hold_yaw_rad", task.hold_yaw_rad, -7.0, 7.0),
        ("above_m", task.above_m, 0.0, 1.0),
        ("gap_m", task.gap_m, 0.0, 0.1),
        ("lift_m", task.lift_m, 0.0, 1.0),
        ("lift_s", task.lift_s, 0.0, 60.0),
        ("carry_s", task.carry_s, 0.0, 60.0),
        ("drop_interval_s", task.drop_interval_s, 0.01, 60.0),
        ("attach_s", task.attach_s, 0.01, 60.0),
        ("back_off_m", task.back_off_m, 0.0, 1.0),
        ("state_timeout_s", task.state_timeout_s, 0.1, 600.0),
        ("max_attempts", f64::from(task.max_attempts), 1.0, 100.0),
        ("max_tilt_rad", task.max_tilt_rad, 0.0, 1.6),
        ("reach_m.0", task.reach_m[0], 0.0, 10.0),
        ("reach_m.1", task.reach_m[1], task.reach_m[0], 10.0),
        ("patience_s", task.patience_s, 0.0, 600.0),
    ];
    at.ranges("task", &ranges)
}
