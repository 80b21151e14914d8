//! The same job as one if/else controller: a phase number and one function, from top to bottom.
//! It is one function on purpose, to show what the other policies improve; compare it with
//! [`super::fsm`].

use ipc_types::GripperGoal;

use super::phase::{Phase, PhaseStatus};
use super::transfer::Transfer;
use super::turn::Turn;

/// One decision.
pub fn decide(memory: &mut Option<Transfer>, turn: &mut Turn<'_>) {
    let Some(transfer) = memory else {
        *memory = Transfer::select("decide", turn);
        return;
    };
    let cube = transfer.cube;
    if transfer.dropped(turn) {
        turn.note_drop(cube);
        turn.hold(GripperGoal::Open);
        *memory = None;
    } else if transfer.cube_gone(turn) {
        turn.hold(GripperGoal::Keep);
        *memory = None;
    } else {
        if transfer.cube_moved(turn) {
            turn.note_resync(cube, transfer.phase);
            transfer.aim(turn);
        }
        let status = transfer.drive(turn);
        let number = transfer.phase as u32;
        if turn.world.job.failure.is_some() {
            turn.hold(GripperGoal::Keep);
            *memory = None;
        } else if status == PhaseStatus::Blocked {
            turn.note_blocked(cube);
            turn.hold(GripperGoal::Keep);
            *memory = None;
        } else if status != PhaseStatus::Running {
            transfer.note_end(format_args!("phase {number}"), status, turn);
            if let Some(&next) = Phase::RING.get(number as usize + 1) {
                if next.holding() && transfer.destination_lost(turn) {
                    transfer.abort(turn);
                }
                transfer.enter(next, turn);
                transfer.drive(turn);
            } else {
                *memory = Transfer::select("decide", turn);
            }
        }
    }
}
