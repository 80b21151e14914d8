//! Paths of a Panda around a wall, checked in double precision.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod common;
mod hostile;
mod led;
mod paths;
mod poses;

#[global_allocator]
static ALLOCATOR: cell_rt::alloc::Counting = cell_rt::alloc::Counting;
