//! Grippers: two fingers that hold by friction, and a suction cup.

pub(crate) mod beam;
pub(crate) mod cup;
pub(crate) mod cups;
pub(crate) mod grippers;
pub(crate) mod hanging;
pub(crate) mod momentum;
pub(crate) mod parallel;
pub(crate) mod suction;
#[cfg(test)]
pub(crate) mod suction_tests;
