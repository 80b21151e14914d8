//! Republishes a running cell on the network: joins the cell like the monitor, and publishes
//! its state over zenoh, as ROS 2 messages in the format of `rmw_zenoh`. See docs/network.md.
//!
//! [`outgoing`] and [`control`] are pure: states in, messages or requests out. [`cell`] joins
//! the bus, [`transport`] is the network, and [`bridge`] is the loop between both.
#![forbid(unsafe_code)]

pub mod args;
pub mod bridge;
pub mod cell;
pub mod clock;
pub mod control;
pub mod endpoints;
pub mod log;
pub mod outgoing;
pub mod ros;
pub mod transport;
pub mod zenoh_link;
