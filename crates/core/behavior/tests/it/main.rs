//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

mod allocation;
mod board_rows;
mod cases;
mod descriptor_check;
mod descriptor_common;
mod descriptor_hostile;
mod descriptor_leaves;
mod descriptor_load;
mod for_each;
#[path = "../../examples/conformance/machine.rs"]
mod machine;
mod machine_alloc;
mod machine_host;
mod machine_levels;
mod machine_load;
mod machine_nested;
mod machine_rows;
mod matrix;
#[path = "../../examples/conformance/tree.rs"]
mod tree;
mod tree_halting;
mod tree_modifiers;
mod tree_records;
mod tree_replace;
mod tree_rows;
mod tree_support;
mod views;

use cell_rt::alloc::Counting;

// Counts per thread, so tests beside each other do not disturb it.
#[global_allocator]
static ALLOCATOR: Counting = Counting;
