//! What the cells of the matrix do, besides picking.

use behavior::matrix::Next;
use robocell_skills::matrix::{SuctionPick as _, goto, pick};
use robocell_skills::{Waypoint, pose};
use robocell_task::{PolicyTime, TraceEvent};

use super::grasp::{self, Grasp, NoGrasp};
use super::hold;
use super::job::{FillBin, State, Turn};
use crate::failure::Failure;

/// Where the bin can be gripped now; the job fails once it could not for too
/// long.
pub(super) fn grasp(turn: &mut Turn<'_>) -> Option<Grasp> {
    let why = match grasp::find(turn) {
        Ok(grasp) => {
            turn.memory.stuck_since = None;
            return Some(grasp);
        }
        Err(why) => why,
    };
    let since = *turn.memory.stuck_since.get_or_insert(turn.now);
    let patience = PolicyTime::from_seconds(turn.of.task.patience_s);
    if turn.now.since(since) >= patience {
        let (failure, text) = match why {
            NoGrasp::Lost => (Failure::BinLost, "is not in the cell any more"),
            NoGrasp::OutOfReach => (Failure::BinOutOfReach, "is out of reach"),
            NoGrasp::NoSurface => (
                Failure::BinCannotBeGripped,
                "has no flat spot that suction can reach",
            ),
        };
        let name = &turn.of.task.bin;
        turn.world
            .fail(failure.reason(), format_args!("{name} {text}"));
        // After another start the patience is the same.
        turn.memory.stuck_since = None;
        turn.arm.path.stop();
        turn.arm.switch(false);
    }
    None
}

/// The bin is looked for, and approached if it can be gripped.
pub(super) fn to_above_bin(turn: &mut Turn<'_>) -> Next {
    let moves = turn.seen(turn.of.bin).is_some_and(|bin| !bin.at_rest);
    // What is attached already is handled by ATTACHED, in the next decision.
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

/// Something is attached: the bin is carried under the dispenser, anything else is
/// let go.
pub(super) fn lift(turn: &mut Turn<'_>) -> Next {
    turn.memory.attached = false;
    if !FillBin::holds(turn) {
        let line = format_args!("[missed] that is not the bin");
        turn.world.out.log(line);
        turn.arm.switch(false);
        return Next::Stay;
    }
    let (of, seconds) = (turn.of, PolicyTime::from_seconds);
    turn.arm.switch(true);
    turn.memory.aside = false;
    turn.world.job.held = Some(of.bin);
    let raised = pose::shifted(&turn.tcp, [0.0, 0.0, of.task.lift_m]);
    let hold = hold::hanging(turn);
    turn.route()
        .avoiding(of.beside_stand)
        .within(seconds(of.task.lift_s), raised)
        .within(seconds(of.task.carry_s), hold)
        .end();
    goto(State::Holding)
}

/// The bin is under the dispenser. A bin held by a wall is turned up first.
///
/// Parts fall until the grip breaks, then the bin is picked up again: a cycle without an end.
/// The job is done after the first whole one, when the bin that fell is held here again, and
/// stays done until a reset while the cycle continues: an outcome that followed each break
/// would be no answer to whether the job was done.
pub(super) fn ask_for_parts(turn: &mut Turn<'_>) -> Next {
    let (of, job) = (turn.of, &mut *turn.world.job);
    if let Some(attempts) = job.attempts_mut(of.bin) {
        attempts.pick = 0;
    }
    if turn.memory.broke && !job.done {
        job.done = true;
        let name = &of.task.bin;
        turn.world.out.event(
            TraceEvent::Done,
            format_args!("[done] {name} is held again after it fell"),
        );
    }
    if hold::opens_up(turn) {
        let io = &mut turn.world.job.io;
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

/// No part would stay in a bin that hangs upside down: it is carried aside and let
/// fall.
fn tip_over(turn: &mut Turn<'_>) {
    if std::mem::replace(&mut turn.memory.aside, true) {
        turn.arm.switch(false);
        return;
    }
    let of = turn.of;
    let name = &of.task.bin;
    turn.world.out.log(format_args!(
        "[hold] {name} hangs upside down, it is let fall to come to rest otherwise"
    ));
    let hold = turn.arm.path.end().map(Waypoint::pose);
    let aside = pose::shifted(&hold.unwrap_or(turn.tcp), of.task.tip_over_m);
    let time = PolicyTime::from_seconds(of.task.lift_s);
    turn.route()
        .avoiding(of.beside_stand)
        .within(time, aside)
        .end();
}

/// The grip is gone: back to the rest pose, and from there to the bin again.
pub(super) fn give_up(turn: &mut Turn<'_>) -> Next {
    let held = turn.state == State::Holding;
    if turn.grip.broken || held {
        turn.memory.broke |= held && turn.grip.broken;
        turn.note_drop(turn.of.bin, held);
    }
    turn.world.job.held = None;
    turn.memory.attached = false;
    back_to_rest(turn)
}

/// A pick-up, or the way to the rest pose, took too long.
pub(super) fn stop_tasks(turn: &mut Turn<'_>) -> Next {
    let of = turn.of;
    turn.world.job.counters.recoveries += 1;
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
    let _failed = turn.count_failed_pick(of.bin, of.task.max_attempts, reason);
    restore(turn)
}

pub(super) fn back_to_rest(turn: &mut Turn<'_>) -> Next {
    if turn.world.is_wound() {
        return restore(turn);
    }
    turn.arm.switch(false);
    turn.memory.stuck_since = None;
    let rest = turn.of.rest;
    turn.route().to(rest).end();
    goto(State::Standby)
}

/// To the rest pose by the configuration of the start.
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

/// What is in the gripper is carried on; without it, or after a reset, the arm
/// returns to its rest pose.
pub(super) fn reconcile(turn: &mut Turn<'_>) -> Next {
    let on_path = turn.is_on_path().unwrap_or(false);
    let attached = turn.gripper.attached == 1;
    let let_go = std::mem::take(&mut turn.memory.let_go);
    if !let_go && (on_path || attached != turn.arm.grip.attached()) {
        // The next decision sees by itself what changed.
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
    // What is let go here is not an event of the next decision.
    turn.arm.grip.update(turn.gripper);
    turn.world.job.held = None;
    back_to_rest(turn)
}
