//! Handlers of the matrix other than those of picking.

use behavior::matrix::Next;
use robocell_skills::matrix::{SuctionPick as _, goto, pick};
use robocell_skills::{Waypoint, pose};
use robocell_task::{PolicyTime, TraceEvent};

use super::grasp::{self, Grasp, NoGrasp};
use super::hold;
use super::job::{FillBin, State, Turn};
use crate::failure::Failure;

/// The spot at which the bin can be gripped now. The job fails once none was found for the
/// patience of the task.
pub(super) fn grasp(turn: &mut Turn<'_>) -> Option<Grasp> {
    let why = match grasp::find(turn) {
        Ok(grasp) => {
            turn.memory.stuck_since = None;
            return Some(grasp);
        }
        Err(why) => why,
    };
    let since = *turn.memory.stuck_since.get_or_insert(turn.now);
    // Patience, because a bin that rolls or rocks has no spot only for a moment.
    let patience = PolicyTime::from_seconds(turn.of.task.patience_s);
    if turn.now.since(since) >= patience {
        let (failure, text) = match why {
            NoGrasp::Lost => (Failure::BinLost, "is not in the cell any more"),
            NoGrasp::OutOfReach => (Failure::BinOutOfReach, "is out of reach"),
            NoGrasp::NoSurface => (Failure::BinCannotBeGripped, "leans too far for suction"),
            NoGrasp::Covered => (
                Failure::BinCannotBeGripped,
                "is upright, and parts cover each spot of its floor that suction can reach",
            ),
        };
        let name = &turn.of.task.bin;
        turn.world
            .fail(failure.reason(), format_args!("{name} {text}"));
        // Another start has the same patience.
        turn.memory.stuck_since = None;
        // The arm stops and releases the bin: a failed job waits for a person, whose hands may
        // be in the cell.
        turn.arm.path.stop();
        turn.arm.switch(false);
    }
    None
}

/// Looks for the bin, and approaches it if it can be gripped.
pub(super) fn to_above_bin(turn: &mut Turn<'_>) -> Next {
    let moves = turn.seen(turn.of.bin).is_some_and(|bin| !bin.at_rest);
    // A bin that is attached already is handled by ATTACHED, in the next decision.
    if !turn.world.job.started || moves || turn.memory.attached {
        return Next::Stay;
    }
    let Some(found) = grasp(turn) else {
        return Next::Stay;
    };
    let (name, side) = (&turn.of.task.bin, found.side.name());
    turn.world
        .out
        .log(format_args!("[decide] -> pick {name} {side}"));
    turn.arm.switch(false);
    let Ok(spot) = FillBin::spot(turn) else {
        return Next::Stay;
    };
    let above = pick::above(turn.of, &spot);
    turn.route().avoiding(spot.obstacles).to(above).end();
    goto(State::Picking)
}

/// Something is attached: the bin is carried under the dispenser, anything else is released.
pub(super) fn lift(turn: &mut Turn<'_>) -> Next {
    turn.memory.attached = false;
    // Suction takes whatever it touches first, which may be a part on the floor of the bin.
    if !FillBin::holds(turn) {
        let line = format_args!("[missed] that is not the bin");
        turn.world.out.log(line);
        turn.arm.switch(false);
        return Next::Stay;
    }
    let (of, seconds) = (turn.of, PolicyTime::from_seconds);
    turn.arm.switch(true);
    turn.memory.aside = false;
    turn.memory.stuck_since = None;
    turn.world.job.held = Some(of.bin);
    let raised = pose::shifted(&turn.tcp, [0.0, 0.0, of.task.lift_m]);
    let hold = hold::hanging(turn);
    // The stand is left out: the bin is in contact with it while it is lifted.
    turn.route()
        .avoiding(of.beside_stand)
        .within(seconds(of.task.lift_s), raised)
        .within(seconds(of.task.carry_s), hold)
        .end();
    goto(State::Holding)
}

/// The bin is under the dispenser; one that is held by a wall is turned upright first.
///
/// Parts fall until the grip breaks, then the bin is picked up again: an endless cycle. The job
/// is done after its first whole round, when the fallen bin is held here again, and it stays
/// done until a reset while the cycle continues: an outcome that changed with each break would
/// not tell whether the job was done.
pub(super) fn ask_for_parts(turn: &mut Turn<'_>) -> Next {
    let (of, job) = (turn.of, &mut *turn.world.job);
    if turn.memory.broke && !job.done {
        job.done = true;
        let name = &of.task.bin;
        turn.world.out.event(
            TraceEvent::Done,
            format_args!("[done] {name} is held again after it fell"),
        );
    }
    if hold::opens_up(turn) {
        end_without_parts(turn);
        // Failed pick-ups count in a row only.
        if let Some(attempts) = turn.world.attempts_mut(of.bin) {
            attempts.pick = 0;
        }
        let io = &mut turn.world.job.io;
        // A counter, not a flag: a request cannot be missed or served twice.
        io.drop_parts = io.drop_parts.wrapping_add(1);
        let pause = PolicyTime::from_seconds(of.task.drop_interval_s);
        turn.arm.again_after(pause, turn.now);
    } else if let Some(upright) = hold::upright(turn) {
        let carry = PolicyTime::from_seconds(of.task.carry_s);
        turn.route()
            .avoiding(of.beside_stand)
            .within(carry, upright)
            .end();
    } else {
        tip_over(turn);
    }
    Next::Stay
}

/// Ends a job that would wait for ever: no part is left that could break the grip. A task that lost
/// its checkpoints has forgotten a break, so physics' count of them decides.
fn end_without_parts(turn: &mut Turn<'_>) {
    let is_out = |(part, _): &(usize, f64)| turn.world.position(*part).is_some();
    let is_empty = turn.of.parts.iter().all(is_out) && !turn.of.parts.is_empty();
    let has_ended = turn.world.job.done || turn.world.job.failure.is_some();
    if !is_empty || has_ended {
        turn.memory.stuck_since = None;
        return;
    }
    let since = *turn.memory.stuck_since.get_or_insert(turn.now);
    // Patience, because the last parts may still fall, and break the grip.
    if turn.now.since(since) < PolicyTime::from_seconds(turn.of.task.patience_s) {
        return;
    }
    if turn.gripper.breaks > 0 {
        turn.memory.broke = true;
        return;
    }
    let name = &turn.of.task.bin;
    turn.world.fail(
        Failure::NoPartsLeft.reason(),
        format_args!("the dispenser is empty, and {name} is still held"),
    );
    // Another start has the same patience.
    turn.memory.stuck_since = None;
}

/// No part would stay in a bin that hangs upside down: it is carried aside, turned onto its side
/// and dropped.
fn tip_over(turn: &mut Turn<'_>) {
    // The first call carries it aside, the second, after arrival, opens the gripper.
    let of = turn.of;
    if std::mem::replace(&mut turn.memory.aside, true) {
        let reason = Failure::BinCannotBeGripped.reason();
        let what = "came to rest upside down";
        let _failed = turn.count_failed_pick(of.bin, of.task.max_attempts, reason, what);
        turn.arm.switch(false);
        return;
    }
    let name = &of.task.bin;
    turn.world.out.log(format_args!(
        "[hold] {name} hangs upside down; it is dropped, to come to rest another way"
    ));
    // From the end of the path, not from the TCP, which lags behind: aside is the same place
    // each time.
    let hold = turn.arm.path.end().map(Waypoint::pose);
    let aside = hold::on_its_side(&hold.unwrap_or(turn.tcp), of.task.tip_over_m);
    let time = PolicyTime::from_seconds(of.task.carry_s);
    turn.route()
        .avoiding(of.beside_stand)
        .within(time, aside)
        .end();
}

/// The grip broke: back to the rest pose, and from there to the bin again.
pub(super) fn give_up(turn: &mut Turn<'_>) -> Next {
    let held = turn.state == State::Holding;
    // Away from HOLDING only a broken grip is a drop; a pick-up that did not attach is an
    // attempt.
    if turn.grip.broken || held {
        turn.memory.broke |= held && turn.grip.broken;
        turn.note_drop(turn.of.bin, held);
    }
    turn.world.job.held = None;
    turn.memory.attached = false;
    back_to_rest(turn)
}

/// A pick-up, or the motion to the rest pose, took too long.
pub(super) fn stop_tasks(turn: &mut Turn<'_>) -> Next {
    let of = turn.of;
    turn.world.job.counters.recoveries += 1;
    // In STANDBY the arm itself is stuck; elsewhere the bin may be the cause, so the arm goes
    // home first.
    if turn.state != State::Standby {
        let line = format_args!("[timeout] pick-up stopped");
        turn.world.out.log(line);
        let _failed = FillBin::failed_again(turn);
        return back_to_rest(turn);
    }
    let arm = turn.world.arm_name();
    let line = format_args!("[timeout] {arm} did not arrive at its rest pose");
    turn.world.out.log(line);
    let reason = Failure::ArmDidNotArrive.reason();
    let what = "was not reached from the rest pose";
    let _failed = turn.count_failed_pick(of.bin, of.task.max_attempts, reason, what);
    restore(turn)
}

pub(super) fn back_to_rest(turn: &mut Turn<'_>) -> Next {
    // A straight way home would keep the turns of the joints, until one is at its limit.
    if turn.world.is_wound() {
        return restore(turn);
    }
    turn.arm.switch(false);
    turn.memory.stuck_since = None;
    let rest = turn.of.rest;
    turn.route().to(rest).end();
    goto(State::Standby)
}

/// To the rest pose through the start configuration.
fn restore(turn: &mut Turn<'_>) -> Next {
    turn.arm.switch(false);
    turn.memory.stuck_since = None;
    turn.arm.since = turn.now;
    let (rest, arm) = (turn.of.rest, turn.world.arm_setup());
    let route = turn.route();
    match arm {
        Some(arm) => route.restoring(arm).to(rest).end(),
        None => route.to(rest).end(),
    }
    goto(State::Standby)
}

/// A bin in the gripper is carried on. Without one, or after a reset, the arm returns to its
/// rest pose.
pub(super) fn reconcile(turn: &mut Turn<'_>) -> Next {
    let on_path = turn.is_on_path().unwrap_or(false);
    let attached = turn.gripper.attached == 1;
    let let_go = std::mem::take(&mut turn.memory.let_go);
    if !let_go && (on_path || attached != turn.arm.grip.attached()) {
        // The next decision finds the changed grip as an event.
        return Next::Stay;
    }
    if attached && !let_go {
        turn.memory.attached = true;
        turn.arm.path.stop();
        let name = &turn.of.task.bin;
        turn.world.out.event(
            TraceEvent::Recover,
            format_args!("[resume] {name} is in the hand"),
        );
        turn.world.job.counters.recoveries += 1;
        return Next::Stay;
    }
    // This release is not an event of the next decision.
    turn.arm.grip.update(turn.gripper);
    turn.world.job.held = None;
    back_to_rest(turn)
}
