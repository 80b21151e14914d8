//! Checks of the settings in the cell file.

use cell_model::{Cell, Checker, ModelError, suggest};
use robocell_task::Settings;

use super::numbers::{MAX_SLOTS, PalletizeTask};
use super::steps::{Sequence, listed};
use super::work_kind::WorkKind;
use crate::check;

impl Settings for PalletizeTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        check::behaviour(at, &self.behaviour)?;
        // Without a supply no bin would arrive, and the job would wait for ever.
        if cell.conveyor.as_ref().is_none_or(|c| c.supply.is_none()) {
            let allowed = "this job needs a [conveyor] with a [conveyor.supply]";
            return Err(at.refuse("task.kind", "'palletize'", allowed));
        }
        let slots = self.slot_x_m.len() * self.slot_y_m.len();
        if slots == 0 || slots > MAX_SLOTS {
            let allowed = format!("1 to {MAX_SLOTS} places are allowed");
            return Err(at.refuse("task.slot_x_m", format!("{slots} places"), allowed));
        }
        let along = |x: &f64| {
            self.slot_y_m
                .iter()
                .map(|y| [*x, *y, self.slot_z_m])
                .collect()
        };
        let slots: Vec<[f64; 3]> = self.slot_x_m.iter().flat_map::<Vec<_>, _>(along).collect();
        check::tool_gets_to(at, "task.slot_x_m", cell.arms.first(), slots)?;
        let key = "task.jig.orientation_wxyz";
        check::unit_quaternion(at, key, &self.jig.orientation_wxyz, 1.0e-4)?;
        steps(self, at)
    }
}

/// Refuses steps that are missing or have no end, and sequences that do not pick the bin, or do
/// not release it.
fn steps(task: &PalletizeTask, at: &Checker<'_>) -> Result<(), ModelError> {
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
