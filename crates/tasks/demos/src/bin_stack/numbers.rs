//! `[task]` with `kind = "bin_stack"`.

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Cell, Checker, ModelError, Shape};
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check;

/// Number of columns: three by three.
pub(super) const COLUMNS: usize = 9;
/// Steps per second of Isaac Sim's sample, in which the cell file gives delays.
pub(super) const STEPS_PER_SECOND: u64 = 60;

/// Largest number of steps of 1/60 s until a bin arrives (28 minutes).
const MAX_STEPS: f64 = 1.0e5;

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
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub rest_position_m: [f64; 3],
    /// How it waits, w x y z.
    pub rest_orientation_wxyz: [f64; 4],
    /// Direction of the arm's plane above the belt, about z (rad).
    #[schemars(range(min = -7.0, max = 7.0))]
    pub belt_yaw_rad: f64,
    /// Half the belt's end along x and y, around the waiting bin (m): while a bin is in there
    /// the belt is stopped.
    #[schemars(inner(range(min = 0.01, max = MAX_COORDINATE_M)))]
    pub belt_end_m: [f64; 2],
    /// Centre of that, on the belt (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub belt_end_position_m: [f64; 3],
    /// Between belt and columns (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub via_position_m: [f64; 3],
    /// Direction of the arm's plane there, about z (rad).
    #[schemars(range(min = -7.0, max = 7.0))]
    pub via_yaw_rad: f64,
    /// Height at which bins travel (m).
    #[schemars(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M))]
    pub carry_height_m: f64,
    /// Tool above the surface it is going to touch (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub hover_m: f64,
    /// Air that is left between cup and surface when suction is switched on (m).
    #[schemars(range(min = 0.0, max = 0.05))]
    pub touch_gap_m: f64,
    /// Air that is left below a bin when it is let go (m).
    #[schemars(range(min = 0.0, max = 0.05))]
    pub place_gap_m: f64,
    /// Pace of the tool on its long ways (m/s).
    #[schemars(range(min = 0.001, max = 5.0))]
    pub speed_m_s: f64,
    /// And where it is about to touch, or to let go (m/s).
    #[schemars(range(min = 0.001, max = 5.0))]
    pub slow_speed_m_s: f64,
    /// Pace at which it turns (rad/s).
    #[schemars(range(min = 0.001, max = 10.0))]
    pub turn_speed_rad_s: f64,
    /// Columns and levels.
    pub stack: BinColumns,
    /// Where bins are turned over.
    pub station: FlippingStation,
    /// A bin comes that many steps of 1/60 s after a pick: least and most.
    pub next_bin_steps: [u32; 2],
    /// Time a state may last (s).
    #[schemars(range(min = 0.1, max = 3600.0))]
    pub state_timeout_s: f64,
    /// Time suction may take to attach a bin, or to let go (s).
    #[schemars(range(min = 0.02, max = 3600.0))]
    pub suction_timeout_s: f64,
    /// Pick-ups or set-downs of one bin that may fail in a row.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub max_attempts: u32,
}

/// `[task.stack]`: nine columns.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinColumns {
    /// Centre of column (0, 0) on its support (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub first_m: [f64; 3],
    /// To the next column of the first index, x and y (m).
    #[schemars(inner(range(min = -2.0, max = 2.0)))]
    pub first_step_m: [f64; 2],
    /// To the next column of the second index, x and y (m).
    #[schemars(inner(range(min = -2.0, max = 2.0)))]
    pub second_step_m: [f64; 2],
    /// Turn of the bins about z (rad).
    #[schemars(range(min = -7.0, max = 7.0))]
    pub bin_yaw_rad: f64,
    /// Direction of the arm's plane above them, about z (rad).
    #[schemars(range(min = -7.0, max = 7.0))]
    pub tool_yaw_rad: f64,
    /// Bins of one column.
    #[schemars(range(min = 1.0, max = 5.0))]
    pub levels: u32,
    /// A bin nearer than this to the axis of its column is in place (m).
    #[schemars(range(min = 1.0e-4, max = 0.5))]
    pub tolerance_m: f64,
    /// And nearer than this to the height of its level (m).
    #[schemars(range(min = 1.0e-4, max = 0.5))]
    pub height_tolerance_m: f64,
}

/// `[task.station]`: a holder of rails for the rim of a bin, open towards the
/// arm; the tool holds the bin from below.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlippingStation {
    /// Middle between the rails, on their upper face (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub position_m: [f64; 3],
    /// Direction in which bins slide in, about z (rad); away from the arm.
    #[schemars(range(min = -7.0, max = 7.0))]
    pub yaw_rad: f64,
    /// Distance from which they slide in (m).
    #[schemars(range(min = 0.01, max = 2.0))]
    pub slide_m: f64,
    /// Height above the rails at which they do (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lift_m: f64,
    /// How far the tool is pushed down out of a bin (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub push_down_m: f64,
    /// Height above the rails of the axis it is turned over about (m).
    #[schemars(range(min = -2.0, max = 2.0))]
    pub turn_height_m: f64,
    /// Distance of the cup from that axis (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_radius_m: f64,
    /// Joints with the cup pointing down before it is turned over, and up
    /// afterwards: at the slide's distance from the holder, on both sides of the
    /// axis (rad).
    #[schemars(inner(range(min = -7.0, max = 7.0)))]
    pub down_joint_positions: [f64; 6],
    /// See `down_joint_positions` (rad).
    #[schemars(inner(range(min = -7.0, max = 7.0)))]
    pub up_joint_positions: [f64; 6],
    /// Waypoints (of 1/60 s) the arm waits before it lets go.
    #[schemars(range(min = 0.0, max = 6000.0))]
    pub wait_steps: u32,
}

impl Settings for BinStackTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        check::behaviour(at, &self.behaviour)?;
        bin_table(at, self, cell)?;
        sensor_of(at, self, cell)?;
        let orientation = &self.rest_orientation_wxyz;
        check::unit_quaternion(at, "task.rest_orientation_wxyz", orientation, 1.0e-3)?;
        self.stack.check(at, self, cell)?;
        let [least, most] = self.next_bin_steps.map(f64::from);
        at.number("task.next_bin_steps.1", most, least.max(1.0), MAX_STEPS)
    }
}

impl BinColumns {
    /// Refuses more bins than the columns hold, and columns out of the arm's reach.
    fn check(&self, at: &Checker<'_>, task: &BinStackTask, cell: &Cell) -> Result<(), ModelError> {
        let bins = cell.objects.iter().filter(|o| o.kind == task.bins);
        let Some(Shape::Bin { size_m, .. }) = bins.clone().map(|o| &o.shape).next() else {
            return Ok(());
        };
        // More bins could never be in place, and the job would not end.
        let wanted = bins.count().min(cell.bins);
        let (levels, places) = (self.levels, COLUMNS * self.levels as usize);
        if wanted > places {
            let allowed = format!(
                "{COLUMNS} columns of {levels} levels have {places} places; lower the `count` \
                 of the object, raise task.stack.levels, or stack fewer with --bins"
            );
            return Err(at.refuse("task.bins", format!("{wanted} bins"), allowed));
        }
        let [x, y, z] = self.first_m;
        let (first, second) = (self.first_step_m, self.second_step_m);
        // The four outer columns bound all others, since a step is the same between any two.
        let corners = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0]];
        // The cup touches the top of a bin that is upside down: one height above its support.
        let levels = [1.0, f64::from(self.levels)];
        let top = |[i, j]: [f64; 2]| {
            let (x, y) = (
                x + first[0] * i + second[0] * j,
                y + first[1] * i + second[1] * j,
            );
            levels.map(|level| [x, y, z + size_m[2] * level])
        };
        let tops = corners.into_iter().flat_map(top);
        check::tool_gets_to(at, "task.stack.first_m", cell.arms.first(), tops)
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
