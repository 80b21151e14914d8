//! The spheres of a robot and of a carried object.

use crate::tree::Attachment;

/// A sphere at an attachment's origin.
#[derive(Debug, Clone)]
pub(crate) struct Ball {
    pub(crate) attachment: Attachment,
    pub(crate) radius: f64,
}

/// Largest number of spheres on a tool.
// Buffers are allocated for this many, so that picking an object up allocates nothing.
pub const MAX_CARRIED: usize = 32;
