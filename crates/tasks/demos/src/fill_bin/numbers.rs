//! `[task]` with `kind = "fill_bin"`.

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Cell, Checker, ModelError, Shape};
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check;

/// Upper bound of the reach of any arm (m): a larger number in a file is an error of units.
const MAX_REACH_M: f64 = 10.0;

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
    /// A fixture close around the bin: not an obstacle while the bin is picked up.
    #[serde(default)]
    pub stand: Option<String>,
    /// Where the cup rests between two picks (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub default_position_m: [f64; 3],
    /// Its orientation there, w x y z.
    #[schemars(inner(range(min = -1.0, max = 1.0)))]
    pub default_orientation_wxyz: [f64; 4],
    /// Where the cup holds a bin that hangs on the inside of its floor (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub hold_position_m: [f64; 3],
    /// Turn of a held bin's long edge about the vertical axis (rad).
    #[schemars(range(min = -7.0, max = 7.0))]
    pub hold_yaw_rad: f64,
    /// The way to the bin goes over a point this far above the surface that is
    /// gripped (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub above_m: f64,
    /// Gap between cup and surface when suction is switched on (m).
    #[schemars(range(min = 0.0, max = 0.1))]
    pub gap_m: f64,
    /// A bin that hangs upside down is dropped this far beside the hold position, x, y and z,
    /// so that it comes to rest on another side (m).
    #[schemars(inner(range(min = -0.5, max = 0.5)))]
    pub tip_over_m: [f64; 3],
    /// A bin is raised by this before it is carried (m),
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lift_m: f64,
    /// in this time (s),
    #[schemars(range(min = 0.0, max = 60.0))]
    pub lift_s: f64,
    /// and carried in this (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub carry_s: f64,
    /// Time between two requests for parts (s).
    #[schemars(range(min = 0.01, max = 60.0))]
    pub drop_interval_s: f64,
    /// Suction that holds nothing after this is switched off again (s).
    #[schemars(range(min = 0.01, max = 60.0))]
    pub attach_s: f64,
    /// A pick-up that takes longer in one state is given up (s).
    #[schemars(range(min = 0.1, max = 600.0))]
    pub state_timeout_s: f64,
    /// Pick-ups of the same bin that fail in a row before the job is given up.
    #[schemars(range(min = 1.0, max = 100.0))]
    pub max_attempts: u32,
    /// A surface that faces away from straight up by more than this cannot be
    /// gripped (rad).
    #[schemars(range(min = 0.0, max = 1.6))]
    pub max_tilt_rad: f64,
    /// Distances from the arm's base, in the plane, between which a surface can
    /// be gripped (m).
    #[schemars(inner(range(min = 0.0, max = MAX_REACH_M)))]
    pub reach_m: [f64; 2],
    /// A bin that cannot be picked up for this long is given up (s).
    #[schemars(range(min = 0.0, max = 600.0))]
    pub patience_s: f64,
}

impl Settings for FillBinTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        check::behaviour(at, &self.behaviour)?;
        let bins = cell.objects.iter();
        // Only a single object, not one of a series: the job needs to know which bin it is.
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
        let orientation = &self.default_orientation_wxyz;
        check::unit_quaternion(at, "task.default_orientation_wxyz", orientation, 1.0e-3)?;
        // Refused at load (ADR 0026): an arm that cannot get there would time out in every
        // cycle.
        let hold = [self.hold_position_m];
        check::tool_gets_to(at, "task.hold_position_m", cell.arms.first(), hold)?;
        let [near, far] = self.reach_m;
        at.number("task.reach_m.1", far, near, MAX_REACH_M)
    }
}
