//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

mod cameras;
mod hostile_urdf;
mod load;
mod mimic;
mod movable;
mod ur10;
mod urdf_readings;
