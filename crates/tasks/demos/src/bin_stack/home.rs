//! Routes back to the rest pose.

use behavior::matrix::Next;
use robocell_skills::matrix::goto;
use robocell_skills::path::{Route, padded};

use super::job::{State, Turn};
use super::paths::{self, Begin};
use super::scene::View;

/// Sends the arm back to its rest pose, clear of all obstacles.
pub(super) fn go_home(turn: &mut Turn<'_>) -> Next {
    retreat(turn, Begin::Directly)
}

pub(super) fn retreat(turn: &mut Turn<'_>, begin: Begin) -> Next {
    turn.memory.forget_bin();
    turn.arm.switch(false);
    let (view, of) = (View::of(turn), turn.of);
    let arm = turn.world.arm_setup();
    if paths::is_in_holder(of, &turn.tcp) {
        // Along the rails first: a planned path would start while the cup is still between
        // them.
        let route = out_of_holder(turn).avoiding(u64::MAX);
        paths::around_to(view, route, of.rest).end();
        return goto(State::Standby);
    }
    let route = raise(turn, of.without_holder, begin).avoiding(u64::MAX);
    // Planned from here (ADR 0021): waypoints by hand beside the arm's base took 15 s more for
    // each run.
    match arm {
        Some(arm) => route.planned_home(arm).to(of.rest).end(),
        None => route.to(of.rest).end(),
    }
    goto(State::Standby)
}

/// Starts a route with a lift to the height of long motions, after the arm's start
/// configuration if `begin` asks for it. An arm that did not arrive twice is not lifted, since
/// it may not get up either.
pub(super) fn raise<'r>(turn: &'r mut Turn<'_>, obstacles: u64, begin: Begin) -> Route<'r> {
    let (of, least, stuck) = (turn.of, turn.own.least_lift_m, turn.memory.stuck);
    let arm = turn.world.arm_setup();
    let route = turn.route().avoiding(obstacles);
    let route = if begin == Begin::Restoring && stuck > 1 {
        route
    } else {
        route.lift(of.task.carry_height_m, least)
    };
    match arm.filter(|_| begin == Begin::Restoring) {
        // All obstacles count while joints are restored: the arm may start that motion from
        // anywhere.
        Some(arm) => route.avoiding(u64::MAX).restoring(arm),
        None => route,
    }
}

/// The route of the cup down out of a bin in the holder, back towards the arm, and turned to
/// point down.
pub(super) fn out_of_holder<'r>(turn: &'r mut Turn<'_>) -> Route<'r> {
    let (of, settle) = (turn.of, turn.numbers.settle);
    let station = &of.task.station;
    let down = paths::pushed_down(of, &turn.tcp);
    let back = paths::moved_back(of, &down);
    let turning = paths::turning(of);
    let mut raised = turning.down;
    raised.position[2] = station.position_m[2] + of.height_m + of.task.hover_m;
    turn.route()
        // Stays below the bin first: a straight way up would lift the bin off its rails.
        .avoiding(of.without_holder)
        .leaning(padded(&station.up_joint_positions))
        .slowly(down)
        .wait(settle)
        .to(back)
        .to(turning.up)
        .by_joints(turning.down, padded(&station.down_joint_positions))
        .to(raised)
}
