//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot continue has failed"
)]

mod cycle;

use cell_rt::alloc::Counting;

// Counts per thread, so tests beside each other do not disturb it.
#[global_allocator]
static ALLOCATOR: Counting = Counting;
