//! What a run of a cell is, for the processes that take part in it.

pub mod children;
pub mod record;
pub mod spec;
pub mod summary;
pub mod worker_args;
