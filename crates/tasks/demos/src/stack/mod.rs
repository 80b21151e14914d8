//! Stacking cubes, with three policies: a library-free state machine, an if/else controller,
//! and a tree in code. Their common parts are beside them; the settings are those of `[task]`
//! in the cell file.

pub mod bt;
pub mod code;
pub mod fsm;
pub mod ifelse;
pub mod numbers;
mod obstruction;
pub mod phase;
pub mod selection;
pub mod setup;
pub mod transfer;
pub mod turn;

use std::sync::Arc;

use cell_model::Cell;
use robocell_task::{Goals, Kind, SetupError, Slots, boxed};

pub use phase::Phase;
pub use robocell_skills::geometry;
pub use setup::StackSetup;

use bt::StackBt;
use code::InCode;
use numbers::StackTask;

/// Distance in height within which a cube is in its layer (m).
pub(crate) const HEIGHT_TOLERANCE_M: f64 = 0.01;

/// The cubes above each other, in the order of the task.
fn goals(task: &StackTask, cell: &Cell) -> Result<Goals, SetupError> {
    let cubes = StackSetup::new(task, cell)?.cubes;
    let lowest_m = (task.base_height_m, task.layer_height_m);
    Ok(Goals(vec![Slots {
        centres: layers(task.stack_position_m, lowest_m, cubes.len()),
        objects: Some(cubes),
        tolerance_m: [task.goal_tolerance_m, HEIGHT_TOLERANCE_M],
    }]))
}

/// Centres of the cubes of a stack, given the height of the lowest and the height of a layer.
pub(crate) fn layers(
    [x, y]: [f64; 2],
    (lowest_m, layer_m): (f64, f64),
    count: usize,
) -> Vec<[f64; 3]> {
    let height_m = |layer: usize| lowest_m + layer as f64 * layer_m;
    (0..count).map(|layer| [x, y, height_m(layer)]).collect()
}

/// `kind = "stack"` and its policies.
pub fn kind() -> Kind<StackTask> {
    Kind::<StackTask>::new("stack")
        .goals(goals)
        .policy("fsm", |task, cell| {
            let setup = StackSetup::new(task, cell)?;
            let decide = fsm::decide;
            Ok(boxed(InCode { setup, decide }))
        })
        .policy("ifelse", |task, cell| {
            let setup = StackSetup::new(task, cell)?;
            let decide = ifelse::decide;
            Ok(boxed(InCode { setup, decide }))
        })
        .policy("bt", |task, cell| {
            let setup = Arc::new(StackSetup::new(task, cell)?);
            let tree = bt::shape::tree();
            let tree = tree.map_err(|error| SetupError::new(cell, error.to_string()))?;
            Ok(Box::new(StackBt::new(setup, tree)))
        })
}
