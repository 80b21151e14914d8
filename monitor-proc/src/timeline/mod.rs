//! The past of the run: the lanes of the timeline, events, incidents, and another time shown from
//! a recording.

pub(crate) mod event_file;
pub(crate) mod incidents;
pub mod lanes;
pub mod recorded;
pub(crate) mod restarts;
pub mod scrub;
