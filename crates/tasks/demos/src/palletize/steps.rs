//! The steps of the work on a bin, as the cell file lists them.

use ipc_types::GripperGoal;

use super::numbers::{PalletizeTask, SequenceTable, StepTable, Suction};
use super::work_kind::WorkKind;

/// One step of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    /// Its name for people.
    pub(super) phase: String,
    pub(super) table: StepTable,
}

/// A sequence of steps.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sequence {
    steps: Vec<Step>,
    /// Whether the bin is on the cup at the start.
    carries: bool,
}

impl Sequence {
    /// The sequence of `kind`; steps that `task` does not have are left out (`check` refuses
    /// them).
    pub(super) fn new(task: &PalletizeTask, kind: WorkKind) -> Self {
        let (_, names) = listed(&task.sequences, kind);
        let step = |name: &String| {
            let table = task.steps.get(name)?.clone();
            let phase = table.phase.clone().unwrap_or_else(|| name.clone());
            Some(Step { phase, table })
        };
        Self {
            steps: names.iter().filter_map(step).collect(),
            carries: !kind.picks(),
        }
    }

    /// The step at index `at`; `None` after the last.
    pub(super) fn step(&self, at: usize) -> Option<&Step> {
        self.steps.get(at)
    }

    /// Whether the bin has to be on the cup in the step `at`: suction was switched on before,
    /// and not off since.
    pub(super) fn holds(&self, at: usize) -> bool {
        // The step that releases the bin does not hold it any more, or a quick release would be
        // a loss.
        let releases = self.suction(at) == Some(Suction::Off);
        let before = (0..at).rev().find_map(|step| self.suction(step));
        !releases && before.map_or(self.carries, |suction| suction == Suction::On)
    }

    /// The gripper's goal in the step `at`.
    pub(super) fn gripper(&self, at: usize) -> GripperGoal {
        if self.holds(at) || self.suction(at) == Some(Suction::On) {
            GripperGoal::Close
        } else {
            GripperGoal::Open
        }
    }

    fn suction(&self, at: usize) -> Option<Suction> {
        self.step(at)?.table.suction
    }
}

/// Key and names of the steps of `kind`.
pub(super) fn listed(table: &SequenceTable, kind: WorkKind) -> (&'static str, &[String]) {
    match kind {
        WorkKind::Pick => ("pick", &table.pick),
        WorkKind::PickFlipped => ("pick_flipped", &table.pick_flipped),
        WorkKind::Flip => ("flip", &table.flip),
        WorkKind::Place => ("place", &table.place),
        WorkKind::PlaceFromBelt => ("place_from_belt", &table.place_from_belt),
        WorkKind::PlaceFromHome => ("place_from_home", &table.place_from_home),
    }
}
