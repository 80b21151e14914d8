//! Errors of obstacles and of their set.

use thiserror::Error;

/// Why an obstacle is refused.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ObstacleError {
    /// A size is negative or not finite, or everything has size zero.
    #[error(
        "an obstacle has the sizes {sizes:?} m and the radius {radius} m; all must be finite and >= 0, and give it a volume"
    )]
    Size {
        /// Half extents of a box or hull; radii and half height of a frustum.
        sizes: [f64; 3],
        /// Radius as given.
        radius: f64,
    },
    /// Points have no convex hull with a volume.
    #[error("the convex hull of {points} points cannot be an obstacle: {why}")]
    Hull {
        /// Number of points.
        points: usize,
        /// The reason.
        why: &'static str,
    },
    /// A compound has no part.
    #[error("a compound obstacle needs at least one part")]
    Empty,
    /// The pose is not finite or its orientation not a unit quaternion.
    #[error("an obstacle's pose is not a finite position with a unit quaternion")]
    Pose,
    /// The set is full.
    #[error(
        "the obstacle set is full: its capacity is {capacity} (each part of a compound counts)"
    )]
    Full {
        /// Its fixed capacity.
        capacity: usize,
    },
    /// No obstacle has this id.
    #[error("unknown obstacle {id}; the set holds {count}")]
    NoSuchId {
        /// The id.
        id: usize,
        /// Number of obstacles of the set.
        count: usize,
    },
}
