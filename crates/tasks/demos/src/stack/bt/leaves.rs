//! Conditions and actions of the stacking tree.

use behavior::Status;
use behavior::board::Fault;
use behavior::tree::{Cx, Leaf};
use ipc_types::GripperGoal;

use super::{StackHost, StackWorld};
use crate::stack::phase::{Phase, PhaseStatus};
use crate::stack::selection;
use crate::stack::transfer::Transfer;
use crate::stack::turn::forget_held;

type Call<'a, 'w> = Cx<'a, 'w, StackHost>;

/// A leaf without state.
pub struct Once(pub fn(&mut StackWorld<'_>) -> Status);

impl Leaf<StackHost> for Once {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        Ok(self.0(cx.world))
    }
}

fn answer(holds: bool) -> Status {
    if holds {
        Status::Success
    } else {
        Status::Failure
    }
}

/// No transfer is in progress, and every cube is at its goal.
pub fn all_stacked(world: &mut StackWorld<'_>) -> Status {
    if world.transfer.is_some() {
        return Status::Failure;
    }
    let all = selection::all_stacked(&mut world.turn);
    if all {
        world.turn.hold(GripperGoal::Keep);
    }
    answer(all)
}

/// The cube that has to be in the gripper is not.
pub fn cube_dropped(world: &mut StackWorld<'_>) -> Status {
    let transfer = world.transfer.as_ref();
    answer(transfer.is_some_and(|transfer| transfer.dropped(&world.turn)))
}

/// Ends the transfer after a drop: the arm stops and the gripper opens.
pub fn clear_dropped(world: &mut StackWorld<'_>) -> Status {
    if let Some(transfer) = world.transfer.take() {
        world.turn.note_drop(transfer.cube);
        world.turn.hold(GripperGoal::Open);
    }
    Status::Success
}

/// The held cube cannot go to its destination: a lower cube is not in place, or another one is
/// there. A cube that is only moved out of the way has no place in the stack at all.
pub fn stack_below_broken(world: &mut StackWorld<'_>) -> Status {
    let held = world.transfer.as_ref().filter(|t| t.phase.holding());
    answer(held.is_some_and(|t| t.aborted || t.destination_lost(&world.turn)))
}

/// Chooses the next cube; runs while none is within reach.
pub fn select_next_cube(world: &mut StackWorld<'_>) -> Status {
    // A cube is in the gripper already, found after a restart: choosing another one would drop
    // it.
    if world.transfer.is_some_and(|t| t.phase.holding()) {
        return Status::Success;
    }
    *world.transfer = selection::select("select", &mut world.turn);
    if world.transfer.is_some() {
        return Status::Success;
    }
    world.turn.hold(GripperGoal::Keep);
    Status::Running
}

/// Ends the transfer.
pub fn clear_transfer(world: &mut StackWorld<'_>) -> Status {
    *world.transfer = None;
    forget_held(world.turn.world.job);
    Status::Success
}

/// One phase of a transfer; most leaves of the tree are of this type.
pub struct PhaseLeaf {
    /// Its name in the tree.
    pub name: &'static str,
    /// The phase.
    pub phase: Phase,
    /// Whether the held cube is taken back; the first such phase chooses the place.
    pub back: bool,
}

impl PhaseLeaf {
    /// Whether the phase has nothing to do: picking up with the cube in the gripper already,
    /// and carrying with the cube at its destination.
    fn is_superfluous(&self, world: &StackWorld<'_>) -> bool {
        let held = world.transfer.as_ref().filter(|t| t.phase.holding());
        held.is_some_and(|transfer| match self.phase {
            Phase::PreGrasp | Phase::Approach | Phase::Grasp => true,
            Phase::Lift | Phase::Transport => transfer.is_there(&world.turn),
            Phase::Lower | Phase::Release | Phase::Retract => false,
        })
    }

    /// Whether a cube that moved away while it was picked up ends the attempt. Above one that
    /// only moved, the fingers are turned again, since it may have other neighbours now.
    fn lost_sight(&self, transfer: &mut Transfer, world: &mut StackWorld<'_>) -> bool {
        let turn = &mut world.turn;
        // Only in APPROACH: in PRE_GRASP the arm follows the cube instead.
        if transfer.cube_moved(turn) && self.phase == Phase::Approach {
            let name = self.name;
            let line = format_args!("[{name}] target drifted, restarting pickup");
            turn.world.out.log(line);
            turn.note_resync(transfer.cube, self.phase);
            return true;
        }
        transfer.cube_gone(turn)
    }

    fn work(&self, transfer: &mut Transfer, world: &mut StackWorld<'_>) -> Status {
        if self.phase == Phase::PreGrasp && transfer.cube_moved(&world.turn) {
            transfer.look(&world.turn);
        }
        // Commanded before the check, so also in the decision in which the check fails.
        let status = transfer.drive(&mut world.turn);
        if self.lost_sight(transfer, world) {
            return Status::Failure;
        }
        match status {
            PhaseStatus::Running => return Status::Running,
            PhaseStatus::Blocked => {
                world.turn.note_blocked(transfer.cube);
                return Status::Failure;
            }
            // A time-out advances: the next phase or a condition finds out what went wrong.
            PhaseStatus::Timeout => {
                let line = format_args!("[{}] timeout, advancing", self.name);
                world.turn.world.out.log(line);
            }
            PhaseStatus::Ok | PhaseStatus::Settled => {}
        }
        transfer.note_end(self.phase.name(), status, &mut world.turn);
        Status::Success
    }
}

impl Leaf<StackHost> for PhaseLeaf {
    /// Whether the phase had nothing to do when it started.
    type State = bool;

    fn start(&self, superfluous: &mut bool, cx: &mut Call<'_, '_>) -> Result<(), Fault> {
        let world = &mut *cx.world;
        *superfluous = self.is_superfluous(world);
        if let Some(transfer) = world.transfer.as_mut().filter(|_| !*superfluous) {
            let turn = &mut world.turn;
            // Once for each return: a later phase would choose another spawn while the cube is
            // on its way.
            if self.back && !transfer.aborted {
                transfer.abort(turn);
            }
            if self.phase == Phase::PreGrasp {
                transfer.look(turn);
            }
            transfer.enter(self.phase, turn);
        }
        Ok(())
    }

    fn tick(&self, superfluous: &mut bool, cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        if *superfluous {
            return Ok(Status::Success);
        }
        let Some(mut transfer) = *cx.world.transfer else {
            return Err(Fault::Node("a phase started without a cube"));
        };
        let status = self.work(&mut transfer, cx.world);
        // A job that failed and is started again checks the content of the gripper.
        let failed = cx.world.turn.world.job.failure.is_some();
        *cx.world.transfer = (!failed).then_some(transfer);
        Ok(status)
    }
}
