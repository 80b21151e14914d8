//! Requests of the operator, the panel, and the hand that drags.

pub(crate) mod contact_stop;
pub mod drag;
pub(crate) mod panel;
pub(crate) mod requests;
