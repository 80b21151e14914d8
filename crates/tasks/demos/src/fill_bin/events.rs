//! The events and handlers of the matrix, by their names in the behaviour file.

use behavior::matrix::Next;
use behavior::numbers::Numbers;
use ipc_types::Pose;
use ipc_types::decision::Outcome;
use robocell_skills::Paces;
use robocell_skills::matrix::{Approach, Handler, MatrixJob, Pending, Spot, SuctionPick};
use robocell_skills::matrix::{pick, when};
use robocell_task::PolicyTime;

use super::handlers;
use super::job::{FillBin, FillBinNumbers, Memory, State, Turn};
use crate::failure::Failure;

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
    use robocell_skills::matrix;

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
