//! The integration tests of this package, in one program: it links once.

mod allocation;
mod bin_stack;
mod coarse;
mod coarse_pyramid;
mod common;
mod exploration;
mod exploration_pyramid;
mod jobs;
mod operator;
mod palletize;
mod palletize_cell;
mod policy_rows;
mod restore;
mod soak;
mod ur10_disturbed;
mod ur10_world;

use cell_rt::alloc::Counting;

// Counts per thread, so tests beside each other do not disturb it.
#[global_allocator]
static ALLOCATOR: Counting = Counting;
