//! Messages to the page: read from the bus, encoded, and sent to all open pages.

mod breakpoints;
pub mod broadcast;
pub mod by_hand;
pub mod hello;
pub mod missed_cycles;
pub(crate) mod pauses;
pub mod publisher;
pub mod real_time_factor;
pub mod scene;
mod scene_reset;
pub mod snapshot;
pub mod status;
