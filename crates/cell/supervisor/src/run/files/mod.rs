//! Files of a run, and the room that they need.

pub(crate) mod incident;
pub mod preflight;
pub mod recording;
pub mod room;
