//! Settings, memory and events of the job.

use behavior::matrix::Next;
use behavior::numbers::Numbers;
use cell_model::{Cell, Shape};
use ipc_types::Pose;
use nalgebra::Vector3;
use robocell_skills::matrix::{self, Approach, Handler, MatrixJob, Pending};
use robocell_skills::matrix::{Spot, SuctionPick, pick, seconds, when};
use robocell_skills::setup::{obstacle_bits, suction_arm};
use robocell_skills::{KeptPose, Paces, named, pose};
use robocell_task::job::MOST_COUNTED;
use robocell_task::{PolicyTime, SetupError};
use serde::{Deserialize, Serialize};

use super::columns::{Columns, Order};
use super::numbers::BinStackTask;
use super::scene::View;
use super::supply::{self, SupplyMemory};
use super::{carry, handlers, paths};
use crate::failure::Failure;

/// One decision.
pub(super) type Turn<'t> = matrix::Turn<'t, BinStack>;

/// Prefix of the names of the fixtures of the flipping station.
const HOLDER: &str = "holder";

named! {
    /// The states.
    pub(super) enum State {
        Standby = "STANDBY",
        Picking = "PICKING",
        Attach = "ATTACH",
        Placing = "PLACING",
        Detach = "DETACH",
        Flipping = "FLIPPING",
    }
}

/// The settings of the cell file, and the values derived from them.
#[derive(Debug)]
pub(super) struct BinStack {
    pub(super) task: BinStackTask,
    pub(super) columns: Columns,
    /// Objects that are bins, by index in the cell file.
    pub(super) bins: Vec<usize>,
    /// Objects of the cell.
    objects: usize,
    /// Number of bins that have to be stacked.
    pub(super) wanted: usize,
    /// Height of a bin (m).
    pub(super) height_m: f64,
    /// Thickness of its floor (m).
    pub(super) wall_m: f64,
    /// Index of the sensor at the end of the belt.
    pub(super) sensor: usize,
    /// Bits of all obstacles except those of the flipping station.
    pub(super) without_holder: u64,
    /// Limits of the arm's joints (rad).
    pub(super) joints: Vec<(f64, f64)>,
    /// Base of the arm, world frame (m).
    pub(super) base: Vector3<f64>,
    /// Pose of the TCP at rest.
    pub(super) rest: Pose,
    pub(super) seed: u64,
}

impl BinStack {
    pub(super) fn new(task: &BinStackTask, cell: &Cell) -> Result<Self, SetupError> {
        let arm = suction_arm(cell)?;
        let objects = cell.objects.iter().enumerate();
        let bins = objects.filter(|(_, object)| object.kind == task.bins);
        let bins: Vec<usize> = bins.map(|(index, _)| index).collect();
        let first = bins.first().and_then(|bin| cell.objects.get(*bin));
        // The shape is taken from the first bin: all bins of a table have the same.
        let Some(Shape::Bin { size_m, wall_m }) = first.map(|object| &object.shape) else {
            let problem = "task.bins names nothing with the shape of a bin";
            return Err(SetupError::new(cell, problem));
        };
        let sensor = cell.sensors.iter().position(|s| s.name == task.sensor);
        Ok(Self {
            columns: Columns::new(task.stack.clone(), size_m[2]),
            objects: cell.objects.len(),
            wanted: bins.len().min(cell.bins),
            bins,
            height_m: size_m[2],
            wall_m: *wall_m,
            sensor: sensor
                .ok_or_else(|| SetupError::new(cell, "task.sensor names no [[sensor]]"))?,
            without_holder: !obstacle_bits(cell, |name| name.starts_with(HOLDER)),
            joints: arm.robot.arm_specs().map(|j| (j.lower, j.upper)).collect(),
            base: arm.base.translation.vector,
            rest: pose::with_unit_quaternion(&Pose {
                position: task.rest_position_m,
                orientation_wxyz: task.rest_orientation_wxyz,
            }),
            seed: cell.seed,
            task: task.clone(),
        })
    }
}

/// Numbers of the behaviour file.
pub(super) struct BinStackNumbers {
    /// The order in which columns are filled.
    pub(super) order: Order,
    /// Cosine of the angle within which a bin is flat, or straight in its column.
    pub(super) straight: f64,
    /// A bin farther than this from the arm's axis cannot be picked (m).
    pub(super) reach_m: f64,
    /// Two bins nearer than this in the plane may be one on the other (m).
    pub(super) beside_m: f64,
    /// A bin higher than this above another one is on top of it (m).
    pub(super) on_top_m: f64,
    /// A bin nearer than this to the middle of the holder is in it, or over it (m).
    pub(super) holder_m: f64,
    /// A joint nearer than this to its limit is caught (rad).
    pub(super) joint_margin_rad: f64,
    /// A bin is lifted by this at least (m).
    pub(super) least_lift_m: f64,
    /// Between places whose directions from the arm differ by more than this the route leads
    /// around the arm (rad).
    pub(super) around_rad: f64,
    /// Time from the start to the first request for a bin.
    pub(super) first_bin: PolicyTime,
    /// Time after which a request without a bin is repeated.
    pub(super) ask_again: PolicyTime,
    /// Time without anything to pick and without a bin on its way, after which bins that are
    /// not in place are given up.
    pub(super) lost_after: PolicyTime,
}

/// The memory of the job; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    /// The bin in progress, by its index in the cell file.
    pub(super) bin: Option<usize>,
    /// The bin has to be turned over before it can be placed.
    pub(super) turning: bool,
    /// Pose of the bin in the frame of the TCP, as it was gripped.
    pub(super) in_hand: Option<KeptPose>,
    /// Its slot: column in the order of filling, level.
    pub(super) slot: Option<(usize, usize)>,
    /// The bin in the gripper has no free slot.
    pub(super) waits: bool,
    /// Suction was switched off to release the bin.
    pub(super) opening: bool,
    /// The bin that was released over its slot and not checked yet.
    pub(super) set_down: Option<usize>,
    /// Number of states in a row that lasted too long.
    pub(super) stuck: u32,
    pub(super) supply: SupplyMemory,
}

impl Memory {
    /// Forgets the bin in progress.
    pub(super) fn forget_bin(&mut self) {
        self.bin = None;
        self.turning = false;
        self.in_hand = None;
        self.slot = None;
        self.waits = false;
        self.opening = false;
    }
}

impl MatrixJob for BinStack {
    type State = State;
    type Memory = Memory;
    type Numbers = BinStackNumbers;

    // Names and conditions only: which pending event counts first is in the behaviour file.
    const EVENTS: &'static [(&'static str, Pending<Self>)] = &[
        ("START", starts),
        ("WAYPOINT_REACHED", when::waypoint_reached),
        ("GOAL_REACHED", when::goal_reached),
        ("ATTACHED", |turn| {
            turn.state == State::Attach && turn.arm.closes() && Self::holds(turn)
        }),
        ("DETACHED", |turn| {
            turn.state == State::Detach && turn.memory.opening && turn.gripper.attached == 0
        }),
        ("TIMEOUT", |turn| {
            let limit = PolicyTime::from_seconds(turn.of.task.state_timeout_s);
            // At rest nothing is in progress: waiting for a bin does not time out.
            let under_way = turn.state != State::Standby || turn.arm.path.is_moving();
            under_way && turn.is_late(limit)
        }),
        ("STOP", when::never),
        ("BROKENGRIP", broken_grip),
        ("NONE", when::never),
    ];
    const HANDLERS: &'static [(&'static str, Handler<Self>)] = &[
        ("to_above_bin", handlers::to_above_bin),
        ("rest", handlers::rest),
        ("aim_again", pick::aim_again),
        ("to_surface", pick::to_surface),
        ("close_gripper", pick::close_gripper),
        ("choose_way", carry::choose_way),
        ("over_holder", carry::over_holder),
        ("over_column", carry::over_column),
        ("watch_slot", carry::watch_slot),
        ("open_gripper", carry::open_gripper),
        ("count_or_regrip", carry::count_or_regrip),
        ("give_up", handlers::give_up),
    ];

    fn numbers(from: &mut Numbers) -> BinStackNumbers {
        BinStackNumbers {
            order: Order::read(from),
            straight: libm::cos(from.number("numbers.straight_rad", 0.0, 1.5)),
            reach_m: from.number("numbers.reach_m", 0.0, 10.0),
            beside_m: from.number("numbers.beside_m", 0.0, 1.0),
            on_top_m: from.number("numbers.on_top_m", 0.0, 1.0),
            holder_m: from.number("numbers.holder_m", 0.0, 1.0),
            joint_margin_rad: from.number("numbers.joint_margin_rad", 0.0, 1.0),
            least_lift_m: from.number("numbers.least_lift_m", 0.0, 1.0),
            around_rad: from.number("numbers.around_rad", 0.0, 3.2),
            first_bin: seconds(from, "first_bin_s", 600.0),
            ask_again: seconds(from, "ask_again_s", 600.0),
            lost_after: seconds(from, "lost_after_s", 600.0),
        }
    }

    fn paces(&self, _own: &BinStackNumbers) -> Paces {
        Paces {
            speed_m_s: self.task.speed_m_s,
            slow_speed_m_s: self.task.slow_speed_m_s,
            turn_speed_rad_s: self.task.turn_speed_rad_s,
        }
    }

    fn is_sound(&self, memory: &Memory) -> bool {
        let known = |object: Option<usize>| object.is_none_or(|index| index < self.objects);
        let held = memory.in_hand.is_none_or(|pose| pose.is_sound());
        // Counters of a damaged checkpoint are refused: a count near its maximum would fail the
        // job at the next error.
        let few = memory.stuck < MOST_COUNTED && memory.supply.picks < u64::from(MOST_COUNTED);
        held && few && known(memory.bin) && known(memory.set_down)
    }

    fn report(turn: &mut Turn<'_>) {
        supply::update(turn);
        handlers::report(turn);
    }

    fn default_pose(&self) -> Option<Pose> {
        Some(self.rest)
    }

    fn reconcile(turn: &mut Turn<'_>) -> Next {
        handlers::reconcile(turn)
    }

    // Called while the operator leads the arm and after the job failed, when `report` is not: a
    // bin at the end of the belt would otherwise be pushed on.
    fn tend(turn: &mut Turn<'_>) {
        supply::run_belt(View::of(turn), turn.world.job);
    }
}

impl SuctionPick for BinStack {
    const ABOVE: State = State::Picking;
    const AT_SURFACE: State = State::Attach;

    fn approach(&self) -> Approach {
        Approach {
            above_m: self.task.hover_m,
            gap_m: self.task.touch_gap_m,
            attach: PolicyTime::from_seconds(self.task.suction_timeout_s),
        }
    }

    fn spot(turn: &mut Turn<'_>) -> Result<Spot, Next> {
        let view = View::of(turn);
        if let Some(bin) = turn.memory.bin.and_then(|bin| view.bin(bin)) {
            return Ok(paths::spot(view, &bin));
        }
        let line = format_args!("[lost] the bin to pick is gone");
        turn.world.out.log(line);
        turn.world.job.counters.resyncs += 1;
        Err(handlers::go_home(turn))
    }

    fn holds(turn: &Turn<'_>) -> bool {
        View::of(turn).held().is_some()
    }

    fn failed_again(turn: &mut Turn<'_>) -> bool {
        let most = turn.of.task.max_attempts.saturating_add(1);
        let reason = Failure::BinCannotBeGripped.reason();
        let bin = turn.memory.bin;
        bin.is_some_and(|bin| turn.count_failed_pick(bin, most, reason, "was not gripped"))
    }

    fn give_up(turn: &mut Turn<'_>) -> Next {
        handlers::go_home(turn)
    }
}

/// The start event was given, the arm is at rest, and a bin can be picked.
fn starts(turn: &Turn<'_>) -> bool {
    let job = &turn.world.job;
    let idle = turn.state == State::Standby && !turn.arm.path.is_moving();
    idle && job.started && !job.done && View::of(turn).candidate().is_some()
}

/// A level, not an edge: after a restart the present grip counts.
fn broken_grip(turn: &Turn<'_>) -> bool {
    let carrying = matches!(turn.state, State::Placing | State::Flipping | State::Detach);
    carrying && turn.arm.closes() && (turn.gripper.attached == 0 || turn.grip.broken)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = include_str!("../../../../../cells/ur10-bin-stack.matrix.toml");

    #[test]
    fn an_order_that_leaves_a_column_out_is_refused_with_its_line() {
        assert!(matrix::load::<BinStack>("bins.toml", FILE).is_ok());
        for (from, to, said) in [
            ("[0, 1, 3,", "[0, 1, 1,", "each number from 0 to 8"),
            ("[1, 2, 3, 2, 1]", "[1, 2, 3, 2]", "9 in all"),
            ("[1, 2, 3, 2, 1]", "[1, 2, 30, 2, 1]", "1 to 9 is allowed"),
            ("\"choose_way\"", "\"back_off\"", "back_off"),
        ] {
            let refused = matrix::load::<BinStack>("bins.toml", &FILE.replace(from, to));
            let why = refused.err().unwrap_or_default();
            assert!(why.contains("bins.toml:") && why.contains(said), "{why}");
        }
    }
}
