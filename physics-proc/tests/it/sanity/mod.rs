//! Plain scenes that belong to no demo: the expectations of every user hold in them, with and
//! without an arm and other objects in the cell. A sample runs with the other tests; the long
//! forms run in .ci/long.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "seconds as ticks"
)]

mod apart;
mod belts;
mod loads;
mod masses;
mod pads;
mod piles;
mod rest;
mod restored;
mod rolling;
mod scene;
mod sink;
mod slopes;
mod thin;
mod towers;
