//! An arm: its joints and drives, its measured state, and its command watchdog.

pub(crate) mod arms;
pub(crate) mod brake;
pub(crate) mod catch_up;
pub(crate) mod delay;
pub(crate) mod drive;
mod faults;
#[cfg(test)]
mod limit_tests;
pub(crate) mod measured;
pub(crate) mod multibody;
pub(crate) mod touch_count;
pub mod touches;
pub(crate) mod violations;
pub mod watchdog;
