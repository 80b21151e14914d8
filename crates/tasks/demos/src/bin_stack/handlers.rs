//! Handlers of the matrix for the states without a bin in the gripper, and those after a bin
//! was lost.

use behavior::matrix::Next;
use ipc_types::decision::Outcome;
use robocell_skills::matrix::goto;
use robocell_skills::{Named as _, pose};
use robocell_task::TraceEvent;
use robocell_task::job::Attempts;

use super::carry::bring;
use super::home::retreat;
use super::job::{State, Turn};
use super::paths::{self, Begin};
use super::scene::View;
use crate::failure::Failure;

pub(super) fn to_above_bin(turn: &mut Turn<'_>) -> Next {
    let view = View::of(turn);
    let Some(bin) = view.candidate() else {
        return Next::Stay;
    };
    let opens = if bin.up() > 0.0 { "upward" } else { "downward" };
    let name = turn.name(bin.object);
    turn.world
        .out
        .log(format_args!("[decide] -> pick {name}, which opens {opens}"));
    // Data of the last bin must not reach the path of the next one.
    turn.memory.forget_bin();
    turn.memory.bin = Some(bin.object);
    // Off before the approach: suction that is on would take the first thing that the cup
    // passes.
    turn.arm.switch(false);
    let above = paths::above(view, &bin);
    let route = turn.route().avoiding(paths::obstacles(view, &bin));
    paths::around_to(view, route, above).end();
    goto(State::Picking)
}

/// At rest: checks whether the bin that was set down is in its slot.
pub(super) fn rest(turn: &mut Turn<'_>) -> Next {
    let Some(object) = turn.memory.set_down.take() else {
        return Next::Stay;
    };
    let in_place = View::of(turn).stacked().any(|bin| bin.object == object);
    let name = turn.name(object);
    let (job, out) = (&mut *turn.world.job, &mut *turn.world.out);
    if in_place {
        out.log(format_args!("[placed] {name}"));
        if let Some(attempts) = job.attempts_mut(0, object) {
            *attempts = Attempts::default();
        }
        return Next::Stay;
    }
    out.log(format_args!(
        "[missed] {name} did not stay where it was set down"
    ));
    // Not in its slot: it may have slid or fallen, so the bin is picked up again; each bin has
    // its own number of attempts.
    job.counters.recoveries += 1;
    if let Some(attempts) = job.attempts_mut(0, object) {
        attempts.place += 1;
        if attempts.place > turn.of.task.max_attempts {
            let why = format_args!("{name} does not stay where it is set down, again and again");
            turn.world.fail(Failure::BinCannotBePlaced.reason(), why);
        }
    }
    Next::Stay
}

/// The grip broke, or the state lasted too long. A bin that is still in the gripper is not let
/// go: its path is planned again.
pub(super) fn give_up(turn: &mut Turn<'_>) -> Next {
    let lost = turn.gripper.attached == 0 || turn.grip.broken;
    let dropped = turn.world.job.held.take_if(|_| lost);
    if let Some(object) = dropped {
        turn.note_drop(object, true);
        // A bin that falls again and again would make an endless job.
        let most = turn.of.task.max_attempts.saturating_add(1);
        turn.count_failed_pick(object, most, Failure::BinCannotBeHeld.reason(), "was lost");
    } else {
        let name = turn.memory.bin.map_or("no bin", |bin| turn.name(bin));
        let state = turn.state.name();
        turn.world
            .out
            .log(format_args!("[timeout] {name} in {state}"));
        turn.memory.stuck += 1;
        turn.world.job.counters.recoveries += 1;
        give_up_for_good(turn);
    }
    // The time in the state restarts here, since the state itself may stay the same.
    turn.arm.since = turn.now;
    let begin = if lost {
        Begin::Directly
    } else {
        Begin::Restoring
    };
    if View::of(turn).held().is_none() {
        return retreat(turn, begin);
    }
    // A failed job keeps the bin in its gripper: released from this height it would drop into
    // the cell.
    if turn.world.job.failure.is_some() {
        return Next::Stay;
    }
    bring(turn, begin)
}

/// Fails the job after too many states in a row that lasted too long.
fn give_up_for_good(turn: &mut Turn<'_>) {
    // A gripper that does not open cannot get better by another attempt.
    let blocked = turn.memory.opening && turn.gripper.attached == 1;
    if turn.memory.stuck < turn.of.task.max_attempts && !blocked {
        return;
    }
    // Another start has the full number of attempts again.
    turn.memory.stuck = 0;
    // The most specific reason first: a caught arm does not arrive either.
    let failure = match turn.state {
        _ if blocked => Failure::GripperBlocked,
        _ if View::of(turn).caught() => Failure::ArmCaught,
        State::Picking => Failure::BinOutOfReach,
        State::Attach => Failure::BinCannotBeGripped,
        _ => Failure::ArmDidNotArrive,
    };
    let (arm, state) = (turn.world.arm_name(), turn.state.name());
    let what = if blocked {
        "does not let go"
    } else {
        "did not finish"
    };
    turn.world
        .fail(failure.reason(), format_args!("{arm} {what} in {state}"));
}

/// Reports the bins in place, and whether the job is done.
pub(super) fn report(turn: &mut Turn<'_>) {
    let view = View::of(turn);
    let (job, out) = (&mut *turn.world.job, &mut *turn.world.out);
    for bin in view.stacked() {
        job.placed
            .push(u32::try_from(bin.object).unwrap_or(u32::MAX));
    }
    let idle = turn.state == State::Standby && !turn.arm.path.is_moving();
    // A bin that still moves may leave its slot; the job would be done with one bin too few.
    let at_rest = view.stacked().all(|bin| bin.at_rest);
    let placed = job.placed.len();
    let done = job.started && idle && at_rest && placed >= turn.of.wanted;
    if done && !job.done {
        out.event(
            TraceEvent::Done,
            format_args!("[decide] -> all {placed} bins stacked"),
        );
    }
    // Not latched: a bin that is pulled out of a column makes the job continue.
    job.done = done;
    out.outcome = match (done, job.started) {
        (true, _) => Outcome::Done,
        (false, true) => Outcome::Running,
        (false, false) => Outcome::Idle,
    };
}

/// Resumes from the observed state, with or without a bin in the gripper, unless the arm is at
/// its goal and the gripper has the expected content.
pub(super) fn reconcile(turn: &mut Turn<'_>) -> Next {
    let at_rest = || pose::distance(&turn.of.rest, &turn.tcp) <= turn.numbers.resume_m;
    // A wound arm is restored even on its path: the rest of the path would turn its joints
    // further.
    let on_path = turn.is_on_path().unwrap_or_else(at_rest) && !turn.world.is_wound();
    let attached = turn.gripper.attached == 1;
    // The states in which the grip is about to change accept both.
    let as_expected = match turn.state {
        State::Standby | State::Picking => !attached,
        State::Attach => true,
        State::Placing | State::Flipping => attached,
        State::Detach => attached || turn.memory.opening,
    };
    if on_path && as_expected {
        return Next::Stay;
    }
    // Off its path the operator led the arm, or it was restarted elsewhere: from an unknown
    // configuration the joints go to those of the start first.
    let begin = if on_path {
        Begin::Directly
    } else {
        Begin::Restoring
    };
    let Some(bin) = View::of(turn).held() else {
        turn.world.job.held = None;
        return retreat(turn, begin);
    };
    let name = turn.name(bin.object);
    turn.world.out.event(
        TraceEvent::Recover,
        format_args!("[resume] {name} is in the hand"),
    );
    bring(turn, begin)
}
