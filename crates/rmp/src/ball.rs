//! The spheres a robot and what it holds are made of.

use crate::tree::Attachment;

/// A sphere at an attachment's origin.
#[derive(Debug, Clone)]
pub(crate) struct Ball {
    pub(crate) attachment: Attachment,
    pub(crate) radius: f64,
}

/// Most spheres of what a tool holds.
pub const MAX_CARRIED: usize = 32;
