//! From the summed leaves to one joint acceleration: `exact` as published, and
//! `cell` within the limits of a real robot.

pub(crate) mod bounds;
pub(crate) mod box_qp;
pub(crate) mod cell;
pub(crate) mod cholesky;
pub(crate) mod exact;
