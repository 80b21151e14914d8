//! The jobs of the demos: what a cell file says about each, and the policies
//! that do it. [`policies`] is the registry of the built-in task program.
//!
//! What may be changed here: everything a demo decides. What a policy is, what
//! it sees and how it is resumed is the crate `robocell-task`.
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
