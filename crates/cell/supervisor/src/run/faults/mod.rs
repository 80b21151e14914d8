//! Faults of a run: those that a script makes, and those that the launcher notices.

pub(crate) mod disturbances;
pub(crate) mod half_made;
pub(crate) mod script;
pub(crate) mod standstill;
pub(crate) mod starvation;
