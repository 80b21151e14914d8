//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

mod allocation;
mod checkpoint;
mod controllers;
mod cycle;
mod planned_goals;
mod support;
mod ur10_motion;
mod ur10_obstacles;
mod ur10_suction;

use cell_rt::alloc::Counting;

// Counts per thread, so tests beside each other do not disturb it.
#[global_allocator]
static ALLOCATOR: Counting = Counting;
