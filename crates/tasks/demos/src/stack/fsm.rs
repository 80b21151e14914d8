//! The library-free state machine: a ring of eight phases, and the edges that leave it. `edge`
//! chooses the edge, `take` carries it out.

use ipc_types::GripperGoal;

use super::phase::PhaseStatus;
use super::transfer::Transfer;
use super::turn::Turn;

/// An edge of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Edge {
    /// The phase is over: to the next one of the ring, or to the next cube.
    Next(PhaseStatus),
    /// The held cube was lost: out of the ring.
    Drop,
    /// The cube cannot be picked up any longer: out of the ring.
    Gone,
    /// The cube moved before it was gripped: back to the first phase.
    Resync,
    /// The gripper does not open: out of the ring, and the job fails.
    Blocked,
}

/// One decision of the machine.
pub fn decide(memory: &mut Option<Transfer>, turn: &mut Turn<'_>) {
    *memory = match memory.take() {
        None => Transfer::select("decide", turn),
        Some(mut state) => match edge(&mut state, turn) {
            None => Some(state),
            Some(edge) => take(edge, state, turn),
        },
    };
}

/// The edge to take in this decision; `None` while the arm works on the phase.
fn edge(state: &mut Transfer, turn: &mut Turn<'_>) -> Option<Edge> {
    // Checks before the command: the arm must not move on with a cube that it lost.
    if state.dropped(turn) {
        return Some(Edge::Drop);
    }
    if state.cube_gone(turn) {
        return Some(Edge::Gone);
    }
    if state.cube_moved(turn) {
        return Some(Edge::Resync);
    }
    match state.drive(turn) {
        PhaseStatus::Running => None,
        PhaseStatus::Blocked => Some(Edge::Blocked),
        over => Some(Edge::Next(over)),
    }
}

/// The state after the edge, with its first command; `None` out of the ring.
fn take(edge: Edge, mut state: Transfer, turn: &mut Turn<'_>) -> Option<Transfer> {
    let mut gripper = GripperGoal::Keep;
    match edge {
        Edge::Next(status) => return next(status, state, turn),
        Edge::Drop => {
            turn.note_drop(state.cube);
            // After a drop the fingers open: the next pick-up starts with an open gripper.
            gripper = GripperGoal::Open;
        }
        Edge::Gone => {}
        Edge::Resync => {
            turn.note_resync(state.cube, state.phase);
            // The failure may be this very resync: then nothing is commanded any more.
            if turn.world.job.failure.is_none() {
                state.aim(turn);
                state.drive(turn);
                return Some(state);
            }
        }
        Edge::Blocked => turn.note_blocked(state.cube),
    }
    turn.hold(gripper);
    None
}

fn next(status: PhaseStatus, mut state: Transfer, turn: &mut Turn<'_>) -> Option<Transfer> {
    state.note_end(state.phase.name(), status, turn);
    let Some(phase) = state.phase.next() else {
        return Transfer::select("decide", turn);
    };
    // Once for each holding phase, at its start: within a phase the arm is committed.
    if phase.holding() && state.destination_lost(turn) {
        state.abort(turn);
    }
    state.enter(phase, turn);
    // The first command is given in the same decision: the arm does not stop between two
    // phases.
    state.drive(turn);
    Some(state)
}
