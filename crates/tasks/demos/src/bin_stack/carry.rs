//! Handlers of the matrix for the states with a bin in the gripper.

use behavior::matrix::Next;
use ipc_types::Pose;
use robocell_skills::matrix::goto;
use robocell_skills::path::padded;
use robocell_skills::{KeptPose, pose};
use robocell_task::PolicyTime;

use super::columns::Slot;
use super::home::{go_home, out_of_holder, raise};
use super::job::{State, Turn};
use super::numbers::STEPS_PER_SECOND;
use super::paths::{self, Begin};
use super::scene::{Bin, View};
use crate::failure::Failure;

/// Carries the held bin to the station or to a column.
pub(super) fn choose_way(turn: &mut Turn<'_>) -> Next {
    bring(turn, Begin::Directly)
}

pub(super) fn bring(turn: &mut Turn<'_>, begin: Begin) -> Next {
    let view = View::of(turn);
    // The grip may have broken since the event was found; BROKENGRIP handles that in its own
    // turn.
    let Some(bin) = view.held() else {
        return Next::Stay;
    };
    let tcp = pose::isometry(&turn.tcp);
    let memory = &mut *turn.memory;
    memory.bin = Some(bin.object);
    // The bin's pose in the cup is taken once, at the grip: every place that follows is
    // computed from it, so a bin that was gripped off its centre is still set down centred.
    memory.in_hand = Some(KeptPose::from(&(tcp.inverse() * bin.pose)));
    memory.opening = false;
    memory.turning = view.inside(&bin);
    // Only a bin from the belt makes room for the next one there; one that is gripped again
    // does not.
    if view.on_belt(&bin) {
        memory.supply.picked(turn.of, turn.now);
    }
    turn.arm.switch(true);
    turn.world.job.held = Some(bin.object);
    if turn.memory.turning {
        return flip(turn, &bin, begin);
    }
    place(turn, &bin, begin)
}

fn flip(turn: &mut Turn<'_>, bin: &Bin, begin: Begin) -> Next {
    let (of, settle) = (turn.of, turn.numbers.settle);
    let name = turn.name(bin.object);
    turn.world.out.log(format_args!("[decide] -> flip {name}"));
    let station = &of.task.station;
    let up = padded(&station.up_joint_positions);
    let before = in_holder(turn, station.lift_m, station.slide_m);
    let turning = paths::turning(of);
    // The bin is turned over already: by hand, or before a restart of the task.
    let route = if paths::is_in_holder(of, &turn.tcp) {
        turn.route()
    } else {
        let over = raise(turn, u64::MAX, begin).to(turning.down);
        over.avoiding(of.without_holder).by_joints(turning.up, up)
    };
    // The holder does not count as an obstacle here: its margin would keep the bin from sliding
    // between the rails.
    route
        .avoiding(of.without_holder)
        .leaning(up)
        .slowly(before)
        .wait(settle)
        .end();
    goto(State::Flipping)
}

fn place(turn: &mut Turn<'_>, bin: &Bin, begin: Begin) -> Next {
    let view = View::of(turn);
    let slot = match view.next_slot(bin) {
        Ok(slot) => slot,
        Err(blocked) => {
            wait_for_slot(turn, bin, blocked);
            return Next::Stay;
        }
    };
    let (i, j) = turn.own.order.column(slot.column);
    let (name, level) = (turn.name(bin.object), slot.level);
    turn.world.out.log(format_args!(
        "[decide] -> place {name} in column ({i}, {j}), level {level}"
    ));
    turn.memory.waits = false;
    // The slot is kept: which slot is next changes as soon as a bin is seen in a column.
    turn.memory.slot = Some((slot.column, slot.level));
    let carry = turn.of.task.carry_height_m;
    // Over the column at the height of long ways first: a straight way to the slot would pass
    // through the columns in front of it.
    let mut over = over_slot(turn, slot, 0.0);
    over.position[2] = carry;
    let settle = turn.numbers.settle;
    let route = raise(turn, paths::obstacles(view, bin), begin).avoiding(u64::MAX);
    paths::around_to(view, route, over).wait(settle).end();
    goto(State::Placing)
}

/// No slot is free: the bin stays in the gripper, and the job fails if that lasts.
fn wait_for_slot(turn: &mut Turn<'_>, bin: &Bin, blocked: Option<(Slot, Bin)>) {
    let name = turn.name(bin.object);
    let why = no_slot(turn, blocked);
    if !turn.memory.waits {
        turn.memory.waits = true;
        turn.arm.since = turn.now;
        turn.arm.path.stop();
        turn.world.out.log(format_args!("[wait] {name}: {why}"));
    }
    let why = format_args!("{name}: {why}");
    if turn.is_late(turn.own.lost_after) {
        turn.world.fail(Failure::PlaceTaken.reason(), why);
    } else {
        turn.world.note_wait(turn.arm.since, why);
    }
}

/// Why there is no slot.
pub(super) fn no_slot(turn: &Turn<'_>, blocked: Option<(Slot, Bin)>) -> String {
    let Some((slot, bin)) = blocked else {
        return "all columns are full".to_owned();
    };
    let (i, j) = turn.own.order.column(slot.column);
    format!("column ({i}, {j}) is taken by {}", turn.name(bin.object))
}

pub(super) fn over_holder(turn: &mut Turn<'_>) -> Next {
    let (of, settle) = (turn.of, turn.numbers.settle);
    let station = &of.task.station;
    let slid_in = in_holder(turn, station.lift_m, 0.0);
    let down = in_holder(turn, of.task.place_gap_m, 0.0);
    // The wait is given in steps of Isaac Sim's sample (1/60 s); ticks are milliseconds.
    let ticks = u64::from(station.wait_steps) * 1000 / STEPS_PER_SECOND;
    turn.route()
        .avoiding(of.without_holder)
        .leaning(padded(&station.up_joint_positions))
        .slowly(slid_in)
        .wait(settle)
        .slowly(down)
        .wait(PolicyTime::from_ticks(ticks))
        .end();
    goto(State::Detach)
}

/// Over its column: down into the slot, unless that is no longer the next free one.
pub(super) fn over_column(turn: &mut Turn<'_>) -> Next {
    let Some((column, level)) = turn.memory.slot else {
        return Next::Stay;
    };
    if let Some(next) = elsewhere(turn) {
        return next;
    }
    let gap = turn.of.task.place_gap_m;
    let down = over_slot(turn, Slot { column, level }, gap);
    turn.route().slowly(down).end();
    goto(State::Detach)
}

/// On the way into a slot: stops before a bin that a person put there.
pub(super) fn watch_slot(turn: &mut Turn<'_>) -> Next {
    if turn.memory.turning || turn.memory.opening {
        return Next::Stay;
    }
    elsewhere(turn).unwrap_or(Next::Stay)
}

/// Brings the held bin to another slot if a person changed the columns: its slot is taken, or is
/// no longer the lowest of its column.
fn elsewhere(turn: &mut Turn<'_>) -> Option<Next> {
    let view = View::of(turn);
    let bin = view.held()?;
    if !turn.memory.waits {
        let (column, level) = turn.memory.slot?;
        let slot = Slot { column, level };
        if view.next_slot(&bin).ok() == Some(slot) {
            return None;
        }
        if let Some(other) = view.blocker(&bin, slot) {
            let why = no_slot(turn, Some((slot, other)));
            turn.world.out.log(format_args!("[taken] {why}"));
        }
        turn.world.job.counters.recoveries += 1;
        turn.arm.since = turn.now;
    }
    let next = place(turn, &bin, Begin::Directly);
    // The state may be that of the new path already.
    Some(if turn.state == State::Placing {
        Next::Stay
    } else {
        next
    })
}

pub(super) fn open_gripper(turn: &mut Turn<'_>) -> Next {
    turn.arm.switch(false);
    // Remembered, so that the opening that follows is not taken for a broken grip.
    turn.memory.opening = true;
    turn.world.out.log(format_args!("<open gripper>"));
    Next::Stay
}

/// The gripper has opened: over a slot, or in the holder, where the bin is gripped again.
pub(super) fn count_or_regrip(turn: &mut Turn<'_>) -> Next {
    turn.memory.opening = false;
    // An arrival: time-outs count in a row only.
    turn.memory.stuck = 0;
    turn.world.job.held = None;
    let view = View::of(turn);
    let bin = turn.memory.bin.and_then(|bin| view.bin(bin));
    let Some(bin) = bin.filter(|_| turn.memory.turning) else {
        // Whether it stayed in place is checked from the rest pose, where the arm no longer
        // touches it.
        turn.memory.set_down = turn.memory.bin;
        return go_home(turn);
    };
    turn.memory.turning = false;
    turn.memory.in_hand = None;
    let name = turn.name(bin.object);
    turn.world.out.log(format_args!(
        "[decide] -> grip {name} again from its bottom"
    ));
    let above = paths::above(view, &bin);
    out_of_holder(turn).to(above).end();
    goto(State::Picking)
}

fn in_holder(turn: &Turn<'_>, height: f64, back: f64) -> Pose {
    paths::in_holder(turn.of, &in_hand(turn), height, back)
}

fn over_slot(turn: &Turn<'_>, slot: Slot, gap: f64) -> Pose {
    paths::over_slot(View::of(turn), slot, &in_hand(turn), gap)
}

fn in_hand(turn: &Turn<'_>) -> Pose {
    turn.memory.in_hand.map_or(Pose::IDENTITY, Pose::from)
}
