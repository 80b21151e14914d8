//! Settings, memory and events of the job.

use behavior::matrix::Next;
use behavior::numbers::Numbers;
use cell_model::{Cell, Shape};
use ipc_types::Pose;
use ipc_types::decision::Outcome;
use nalgebra::{Isometry3, Vector3};
use robocell_skills::matrix::{self, Approach, Handler, MatrixJob, Pending, Spot, SuctionPick};
use robocell_skills::matrix::{pick, when};
use robocell_skills::setup::{obstacle_bits, suction_arm};
use robocell_skills::{Paces, named, pose};
use robocell_task::{PolicyTime, SetupError};
use serde::{Deserialize, Serialize};

use super::handlers;
use super::numbers::FillBinTask;
use crate::failure::Failure;

/// One decision.
pub(super) type Turn<'t> = matrix::Turn<'t, FillBin>;

named! {
    /// The states.
    pub(super) enum State {
        Standby = "STANDBY",
        Picking = "PICKING",
        Attach = "ATTACH",
        Holding = "HOLDING",
    }
}

/// The settings of the cell file, and the values derived from them.
#[derive(Debug)]
pub(super) struct FillBin {
    pub(super) task: FillBinTask,
    /// The bin, by index in the cell file.
    pub(super) bin: usize,
    /// Its outer edge lengths (m).
    pub(super) size: Vector3<f64>,
    /// Thickness of its floor and walls (m).
    pub(super) wall_m: f64,
    /// Objects that may be in the bin: index in the cell file, and radius of the enclosing ball
    /// (m).
    pub(super) parts: Vec<(usize, f64)>,
    /// Base of the arm, world frame.
    pub(super) base: Isometry3<f64>,
    /// Bits of the obstacles that count while the bin is picked up: all but its stand.
    pub(super) beside_stand: u64,
    /// Pose of the TCP at rest.
    pub(super) rest: Pose,
}

impl FillBin {
    pub(super) fn new(task: &FillBinTask, cell: &Cell) -> Result<Self, SetupError> {
        let broken = |problem: String| SetupError::new(cell, problem);
        let base = suction_arm(cell)?.base;
        let bin = cell
            .object_index(&task.bin)
            .map_err(|error| broken(format!("task.bin: {error}")))?;
        let shape = cell.objects.get(bin).map(|object| &object.shape);
        let Some(Shape::Bin { size_m, wall_m }) = shape else {
            return Err(broken(format!("task.bin: '{}' is not a bin", task.bin)));
        };
        let objects = cell.objects.iter().enumerate();
        Ok(Self {
            bin,
            size: Vector3::from(*size_m),
            wall_m: *wall_m,
            parts: objects
                .filter(|(index, _)| *index != bin)
                .map(|(index, object)| (index, object.shape.bounding_radius()))
                .collect(),
            base,
            beside_stand: !obstacle_bits(cell, |name| task.stand.as_deref() == Some(name)),
            rest: pose::with_unit_quaternion(&Pose {
                position: task.default_position_m,
                orientation_wxyz: task.default_orientation_wxyz,
            }),
            task: task.clone(),
        })
    }
}

/// Numbers of the behaviour file.
pub(super) struct FillBinNumbers {
    /// Pace of the cup down to the surface (m/s).
    pub(super) slow_speed_m_s: f64,
    /// Free radius the cup needs on a floor with parts (m).
    pub(super) room_m: f64,
    /// Spots of the floor that are tried, as fractions of the space between the walls.
    pub(super) spots: Vec<f64>,
    /// Cosine of the largest angle between a side and the cup at which the side counts as held.
    pub(super) facing: f64,
    /// Cosine of the angle up to which a bin opens upward.
    pub(super) opens_up: f64,
}

/// The memory of the job; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "independent facts, each true or not"
)]
pub(super) struct Memory {
    /// An attachment that was not handled yet.
    pub(super) attached: bool,
    /// Time since which the bin cannot be picked up.
    pub(super) stuck_since: Option<PolicyTime>,
    /// The task was reset: a held object is released first.
    pub(super) let_go: bool,
    /// A grip broke since the job started.
    pub(super) broke: bool,
    /// A bin that hangs upside down was carried aside.
    pub(super) aside: bool,
}

impl MatrixJob for FillBin {
    type State = State;
    type Memory = Memory;
    type Numbers = FillBinNumbers;

    // Names and conditions only: which pending event counts first is in the behaviour file.
    const EVENTS: &'static [(&'static str, Pending<Self>)] = &[
        ("START", starts),
        ("WAYPOINT_REACHED", when::waypoint_reached),
        ("GOAL_REACHED", when::goal_reached),
        ("ATTACHED", |turn| turn.memory.attached),
        ("DETACHED", |turn| turn.grip.detached),
        ("TIMEOUT", when::never),
        ("STOP", lasts_too_long),
        ("NONE", when::never),
    ];
    const HANDLERS: &'static [(&'static str, Handler<Self>)] = &[
        ("to_above_bin", handlers::to_above_bin),
        ("to_surface", pick::to_surface),
        ("aim_again", pick::aim_again),
        ("close_gripper", pick::close_gripper),
        ("lift", handlers::lift),
        ("ask_for_parts", handlers::ask_for_parts),
        ("give_up", handlers::give_up),
        ("stop_tasks", handlers::stop_tasks),
    ];

    fn numbers(from: &mut Numbers) -> FillBinNumbers {
        let mut angle = |key: &str| libm::cos(from.number(key, 0.0, 1.5));
        FillBinNumbers {
            facing: angle("numbers.facing_rad"),
            opens_up: angle("numbers.opens_up_rad"),
            slow_speed_m_s: from.number("numbers.slow_speed_m_s", 0.001, 5.0),
            room_m: from.number("numbers.room_m", 0.0, 1.0),
            spots: from.list("numbers.spots", -1.0, 1.0),
        }
    }

    /// Long ways are as fast as the controller allows.
    fn paces(&self, own: &FillBinNumbers) -> Paces {
        Paces {
            slow_speed_m_s: own.slow_speed_m_s,
            ..Paces::default()
        }
    }

    fn reset(memory: &mut Memory) {
        memory.let_go = true;
    }

    fn observe(turn: &mut Turn<'_>) {
        // Kept until it is handled; an attachment that ended before that is dropped.
        turn.memory.attached |= turn.grip.attached;
        turn.memory.attached &= turn.gripper.attached == 1;
        if turn.grip.attached {
            // What the operator attached during a pause stays attached until ATTACHED
            // identifies it.
            turn.arm.switch(true);
        }
    }

    fn report(turn: &mut Turn<'_>) {
        let holds = Self::holds(turn);
        let job = &turn.world.job;
        turn.world.out.outcome = match (job.done, job.started || holds) {
            (true, _) => Outcome::Done,
            (false, true) => Outcome::Running,
            (false, false) => Outcome::Idle,
        };
    }

    fn default_pose(&self) -> Option<Pose> {
        Some(self.rest)
    }

    fn reconcile(turn: &mut Turn<'_>) -> Next {
        handlers::reconcile(turn)
    }
}

impl SuctionPick for FillBin {
    const ABOVE: State = State::Picking;
    const AT_SURFACE: State = State::Attach;

    fn approach(&self) -> Approach {
        Approach {
            above_m: self.task.above_m,
            gap_m: self.task.gap_m,
            attach: PolicyTime::from_seconds(self.task.attach_s),
        }
    }

    fn spot(turn: &mut Turn<'_>) -> Result<Spot, Next> {
        let found = handlers::grasp(turn).ok_or(Next::Stay);
        found.map(|grasp| Spot {
            at: grasp.at,
            obstacles: turn.of.beside_stand,
            at_rest: turn.seen(turn.of.bin).is_some_and(|bin| bin.at_rest),
        })
    }

    /// Whether the bin is held, and nothing else.
    fn holds(turn: &Turn<'_>) -> bool {
        turn.held() == Some(turn.of.bin)
    }

    fn failed_again(turn: &mut Turn<'_>) -> bool {
        let (bin, most) = (turn.of.bin, turn.of.task.max_attempts);
        let reason = Failure::BinCannotBeGripped.reason();
        turn.count_failed_pick(bin, most, reason, "was not gripped")
    }

    fn give_up(turn: &mut Turn<'_>) -> Next {
        handlers::back_to_rest(turn)
    }
}

/// Whether a pick-up, or the motion to the rest pose, lasts too long.
fn lasts_too_long(turn: &Turn<'_>) -> bool {
    let limit = PolicyTime::from_seconds(turn.of.task.state_timeout_s);
    let under_way = match turn.state {
        State::Picking | State::Attach => true,
        State::Standby => turn.arm.path.is_moving(),
        // Holding has no limit: how long the grip lasts is the point of the job.
        State::Holding => false,
    };
    under_way && turn.is_late(limit)
}

/// The start event is latched: it stays pending until the arm moves.
fn starts(turn: &Turn<'_>) -> bool {
    let idle = turn.state == State::Standby && !turn.arm.path.is_moving();
    turn.world.job.started && idle && !turn.arm.grip.attached()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = include_str!("../../../../../cells/ur10-fill-bin.matrix.toml");

    #[test]
    fn a_name_without_a_meaning_is_refused_with_its_line_and_the_nearest() {
        for (from, to, said) in [
            ("\"ask_for_parts\"", "\"ask_for_part\"", "ask_for_parts"),
            ("settle_s = ", "settles_s = ", "'numbers.settle_s'"),
            ("ease_m = 0.001", "ease_m = 7.0", "0 to 0.1 is allowed"),
            ("\nPICKING = {", "\nPICKIN = {", "'precision.PICKING.axis'"),
        ] {
            let wrong = FILE.replace(from, to);
            let refused = matrix::load::<FillBin>("fill.toml", &wrong);
            let why = refused.err().unwrap_or_default();
            assert!(why.contains("fill.toml:") && why.contains(said), "{why}");
        }
    }
}
