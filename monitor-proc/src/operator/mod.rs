//! Execution of the commands of pages in a live cell.

pub mod policy_file;
pub mod queue;
pub mod recordings;
