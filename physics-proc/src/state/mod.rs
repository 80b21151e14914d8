//! The state in messages and bytes: the state message, snapshots, the hash.

pub(crate) mod hash;
pub(crate) mod lost;
pub(crate) mod snapshot;
pub(crate) mod tap;
pub(crate) mod touching;
