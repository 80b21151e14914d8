//! The robot's side of the Franka control interface, as a client sees it.
#![allow(clippy::unwrap_used, reason = "tests")]

mod allocation;
mod ends;
mod gripper;
mod messages;
mod motions;
mod rules;
mod support;

use cell_rt::alloc::Counting;

// Counts per thread, so tests beside each other do not disturb it.
#[global_allocator]
static ALLOCATOR: Counting = Counting;
