//! Execution of the commands of pages in a live cell.

pub(crate) mod live_page;
pub mod policy_file;
pub mod queue;
pub mod recordings;
