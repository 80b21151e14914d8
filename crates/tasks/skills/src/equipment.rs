//! Waiting, and the cell's equipment.

use behavior::Status;
use robocell_task::PolicyTime;

use crate::progress::Progress;
use crate::skill::Skill;
use crate::world::World;

/// Keeps the arm at its last goal for this time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wait {
    /// How long.
    pub time: PolicyTime,
}

/// Starts or stops the belt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conveyor {
    /// Whether it shall run.
    pub run: bool,
}

/// Requests the next bin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AddBin;

/// Requests parts from the dispenser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DropParts;

impl Skill for Wait {
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if world.begin(&mut progress.step) >= self.time {
            Status::Success
        } else {
            Status::Running
        }
    }
}

impl Skill for Conveyor {
    fn step(&self, _progress: &mut Progress, world: &mut World<'_>) -> Status {
        world.job.io.conveyor_running = self.run;
        Status::Success
    }
}

impl Skill for AddBin {
    fn step(&self, _progress: &mut Progress, world: &mut World<'_>) -> Status {
        // A counter: physics serves its increase, so a repeated message requests nothing twice.
        world.job.io.add_bin += 1;
        Status::Success
    }
}

impl Skill for DropParts {
    fn step(&self, _progress: &mut Progress, world: &mut World<'_>) -> Status {
        world.job.io.drop_parts += 1;
        Status::Success
    }
}
