//! Shows a recording on the page like a live cell: without a bus, at the pace of a clock.

pub mod args;
pub mod clock;
mod page_record;
pub mod player;
mod queue;
pub mod show;
mod timeline;
