//! Requests of the operator, the panel, and the hand that drags.

pub mod drag;
pub(crate) mod panel;
pub(crate) mod requests;
