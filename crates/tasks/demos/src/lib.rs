//! The jobs of the demos: the settings of each in a cell file, and its policies. [`policies`]
//! is the registry of the built-in task program.
//!
//! Everything that a demo decides is here. Policies in general, their observations and how they
//! are resumed are the subject of the crate `robocell-task`.
#![forbid(unsafe_code)]

pub mod bin_stack;
pub mod check;
pub mod cube;
pub mod failure;
pub mod fill_bin;
pub mod palletize;
pub mod pyramid;
pub mod reach;
pub mod stack;

use robocell_skills::with_file_jobs;
use robocell_task::Policies;

/// All demos.
pub fn policies() -> Policies {
    with_file_jobs(Policies::new())
        .with(cube::kind())
        .with(stack::kind())
        .with(pyramid::kind())
        .with(reach::kind())
        .with(palletize::kind())
        .with(fill_bin::kind())
        .with(bin_stack::kind())
}
