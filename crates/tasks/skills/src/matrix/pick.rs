//! Picking an object up by suction: handlers that jobs share. Above the object, down
//! to its surface, at rest, eased off, suction on; where nothing attaches, again
//! in place, then once more from above.

use behavior::matrix::Next;
use ipc_types::Pose;
use robocell_task::PolicyTime;

use super::job::{MatrixJob, Turn};
use super::run::goto;
use crate::path::Waypoint;
use crate::pose::along_approach;
use crate::suction;

/// Time in the state after which suction is switched on although the arm moves.
const REST_LIMIT: PolicyTime = PolicyTime::from_ticks(6_000);

/// Where an object can be gripped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The TCP where the cup touches, with x into the surface; world frame.
    pub at: Pose,
    /// Fixtures that count as obstacles on the way there.
    pub obstacles: u64,
    /// The object does not move.
    pub at_rest: bool,
}

/// Distances and times of a pick-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// The way to the object leads over a point this far above its surface (m).
    pub above_m: f64,
    /// Gap between cup and surface when suction is switched on (m).
    pub gap_m: f64,
    /// Suction that attached nothing after this is switched off.
    pub attach: PolicyTime,
}

/// A job with a suction pick-up.
pub trait SuctionPick: MatrixJob {
    /// The state on the way to the point above the object.
    const ABOVE: Self::State;
    /// The state at the surface.
    const AT_SURFACE: Self::State;

    /// Its distances and times.
    fn approach(&self) -> Approach;

    /// Where the object can be gripped now, or what to do instead.
    ///
    /// # Errors
    /// The handler's answer where it cannot be gripped.
    fn spot(turn: &mut Turn<'_, Self>) -> Result<Spot, Next>;

    /// Whether the cup holds what the job wants.
    fn holds(turn: &Turn<'_, Self>) -> bool;

    /// Counts a pick-up that failed; whether that was one too many.
    fn failed_again(turn: &mut Turn<'_, Self>) -> bool;

    /// Back to where the arm waits; answers the state of that.
    fn give_up(turn: &mut Turn<'_, Self>) -> Next;
}

/// The TCP above the surface of `spot`.
pub fn above<J: SuctionPick>(of: &J, spot: &Spot) -> Pose {
    along_approach(&spot.at, -of.approach().above_m)
}

/// On the way above the object: aims at it where it is now.
pub fn aim_again<J: SuctionPick>(turn: &mut Turn<'_, J>) -> Next {
    match J::spot(turn) {
        Ok(spot) => {
            aim(turn, &spot);
            Next::Stay
        }
        Err(instead) => instead,
    }
}

fn aim<J: SuctionPick>(turn: &mut Turn<'_, J>, spot: &Spot) {
    let Pose {
        position,
        orientation_wxyz,
    } = above(turn.of, spot);
    if let Some(end) = turn.arm.path.end().copied() {
        turn.arm.path.aim(Waypoint {
            position,
            orientation_wxyz,
            ..end
        });
    }
}

/// Above the object: down to its surface, once it does not move.
pub fn to_surface<J: SuctionPick>(turn: &mut Turn<'_, J>) -> Next {
    let spot = match J::spot(turn) {
        Ok(spot) => spot,
        Err(instead) => {
            turn.arm.path.again();
            return instead;
        }
    };
    if !spot.at_rest {
        turn.arm.path.again();
        aim(turn, &spot);
        return Next::Stay;
    }
    turn.arm.refused = 0;
    down(turn, &spot);
    goto(J::AT_SURFACE)
}

fn down<J: SuctionPick>(turn: &mut Turn<'_, J>, spot: &Spot) {
    let gap = turn.of.approach().gap_m;
    let numbers = turn.numbers;
    let surface = along_approach(&spot.at, -gap);
    let eased = along_approach(&surface, -numbers.ease_m);
    turn.route()
        .avoiding(spot.obstacles)
        .slowly(surface)
        .wait(numbers.settle)
        .within(numbers.ease, eased)
        .end();
}

/// At the surface: suction on. Reached again, nothing attached.
pub fn close_gripper<J: SuctionPick>(turn: &mut Turn<'_, J>) -> Next {
    if J::holds(turn) {
        // Perhaps by the operator's command.
        turn.arm.switch(true);
        return Next::Stay;
    }
    if turn.arm.closes() {
        return not_gripped(turn);
    }
    // The wait at the surface is long enough if the controller runs on time. If it gets too little
    // processor time the arm arrives later, and a tool that moves while the cup locks breaks the
    // grip. An arm that does not come to rest tries it nevertheless: the job handles a broken grip.
    if !turn.world.arm_is_at_rest() && !turn.is_late(REST_LIMIT) {
        turn.arm.path.again();
        return Next::Stay;
    }
    // A cup that is on has to be seen off first.
    let on = turn.gripper.suction == 0;
    turn.arm.switch(on);
    if on {
        turn.world.out.log(format_args!("<close gripper>"));
    }
    let attach = turn.of.approach().attach;
    turn.arm.again_after(attach, turn.now);
    Next::Stay
}

fn not_gripped<J: SuctionPick>(turn: &mut Turn<'_, J>) -> Next {
    let why = suction::refusal(turn.gripper);
    let line = format_args!("[missed] suction: {why}");
    turn.world.out.log(line);
    turn.arm.switch(false);
    turn.arm.refused += 1;
    if turn.arm.refused < turn.numbers.tries_in_place {
        match J::spot(turn) {
            Ok(spot) => down(turn, &spot),
            Err(instead) => return instead,
        }
        return Next::Stay;
    }
    turn.world.job.counters.recoveries += 1;
    if J::failed_again(turn) {
        return J::give_up(turn);
    }
    match J::spot(turn) {
        Ok(spot) => {
            let back = above(turn.of, &spot);
            turn.route().avoiding(spot.obstacles).slowly(back).end();
            goto(J::ABOVE)
        }
        Err(instead) => instead,
    }
}
