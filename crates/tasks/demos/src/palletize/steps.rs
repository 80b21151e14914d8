//! The steps of the work on a bin, as the cell file lists them.

use cell_model::{Checker, ModelError, suggest};
use ipc_types::GripperGoal;

use super::memory::WorkKind;
use super::numbers::{PalletizeTask, SequenceTable, StepTable, Suction};

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
fn listed(table: &SequenceTable, kind: WorkKind) -> (&'static str, &[String]) {
    match kind {
        WorkKind::Pick => ("pick", &table.pick),
        WorkKind::PickFlipped => ("pick_flipped", &table.pick_flipped),
        WorkKind::Flip => ("flip", &table.flip),
        WorkKind::Place => ("place", &table.place),
        WorkKind::PlaceFromBelt => ("place_from_belt", &table.place_from_belt),
        WorkKind::PlaceFromHome => ("place_from_home", &table.place_from_home),
    }
}

/// Refuses steps that are missing or have no end, and sequences that do not pick the bin, or do
/// not release it.
pub(super) fn check(task: &PalletizeTask, at: &Checker<'_>) -> Result<(), ModelError> {
    for (name, step) in &task.steps {
        if step.go.is_none() && step.wait_s.is_none() && step.suction.is_none() {
            let key = format!("task.steps.{name}");
            let allowed = "a step needs 'go', 'wait_s' or 'suction' to end";
            return Err(at.refuse(&key, "without an end", allowed));
        }
    }
    let known: Vec<&str> = task.steps.keys().map(String::as_str).collect();
    for kind in WorkKind::ALL {
        let (key, names) = listed(&task.sequences, kind);
        let key = format!("task.sequences.{key}");
        for (index, name) in names.iter().enumerate() {
            if !task.steps.contains_key(name) {
                let advice = suggest::advice(name, &known);
                let allowed = format!("no such step in [task.steps]; {advice}");
                return Err(at.refuse(&format!("{key}.{index}"), format!("'{name}'"), allowed));
            }
        }
        // After a pick the bin must be on the cup and after any other sequence it must not: the
        // table relies on it.
        let carries = Sequence::new(task, kind).holds(names.len());
        if carries != kind.picks() {
            let (is, allowed) = if carries {
                (
                    "a sequence that keeps the bin",
                    "a step with suction = \"off\"",
                )
            } else {
                (
                    "a sequence that takes no bin",
                    "a step with suction = \"on\"",
                )
            };
            return Err(at.refuse(&key, is, format!("{allowed} is needed")));
        }
    }
    Ok(())
}
