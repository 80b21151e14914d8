//! Trees of BehaviorTree.CPP, imported and ticked.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::result_large_err,
    reason = "in tests"
)]

mod nodes;
mod provided;
mod random;
mod reference;
mod refused;
mod support;
mod tutorial;
