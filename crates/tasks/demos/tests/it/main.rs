//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

mod allocation;
mod bin_stack;
mod coarse;
mod coarse_pyramid;
mod common;
mod exploration;
mod exploration_pyramid;
mod hostile_cell;
mod jobs;
mod operator;
mod palletize;
mod palletize_cell;
mod policy_rows;
mod pyramid_cell;
mod restore;
mod soak;
mod ur10_disturbed;
mod ur10_world;

use cell_rt::alloc::Counting;

// Counts per thread, so tests beside each other do not disturb it.
#[global_allocator]
static ALLOCATOR: Counting = Counting;
