//! Plain scenes that are those of no demo: what every user expects of them holds, with and
//! without an arm in the cell, whatever else is in it. A sample runs with the other tests; the
//! long forms run in .ci/long.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "seconds as ticks"
)]

mod apart;
mod belts;
mod masses;
mod piles;
mod rest;
mod restored;
mod rolling;
mod scene;
mod towers;
