//! `robocell bench` starts this program.

use std::process::ExitCode;

// Counts allocations for the rows of `behavior`; the counter costs every allocation the same.
#[global_allocator]
static ALLOCATOR: cell_rt::alloc::Counting = cell_rt::alloc::Counting;

fn main() -> ExitCode {
    robocell_benches::main(None)
}
