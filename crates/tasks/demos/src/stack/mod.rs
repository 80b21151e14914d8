//! Stacking cubes, with three policies: a library-free state machine, an if/else controller,
//! and a tree in code. Their common parts are beside them; the settings are those of `[task]`
//! in the cell file.

pub mod bt;
pub mod code;
pub mod fsm;
pub mod ifelse;
pub mod numbers;
pub mod phase;
pub mod selection;
pub mod setup;
pub mod transfer;
pub mod turn;

use std::sync::Arc;

use robocell_task::{Kind, SetupError, boxed};

pub use phase::Phase;
pub use robocell_skills::geometry;
pub use setup::StackSetup;

use bt::StackBt;
use code::InCode;
use numbers::StackTask;

/// `kind = "stack"` and its policies.
pub fn kind() -> Kind<StackTask> {
    Kind::<StackTask>::new("stack")
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
