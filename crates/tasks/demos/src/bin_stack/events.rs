//! The events and handlers of the matrix, by their names in the behaviour file.

use behavior::matrix::Next;
use behavior::numbers::Numbers;
use ipc_types::Pose;
use robocell_skills::Paces;
use robocell_skills::matrix::{Approach, Handler, MatrixJob, Pending};
use robocell_skills::matrix::{Spot, SuctionPick, pick, seconds, when};
use robocell_task::PolicyTime;
use robocell_task::job::MOST_COUNTED;

use super::columns::Order;
use super::job::{BinStack, BinStackNumbers, Memory, State, Turn};
use super::scene::View;
use super::{carry, handlers, home, paths, supply};
use crate::failure::Failure;

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
        Err(home::go_home(turn))
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
        home::go_home(turn)
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
    use robocell_skills::matrix;

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
