//! A recorded file on the page, as if it were live: no bus, a clock of its own.

pub mod args;
pub mod clock;
mod desk;
pub mod player;
pub mod show;
