//! The shapes an obstacle may have, and their exact distances.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector2, Vector3};

use crate::ObstacleError;
use crate::hull::Hull;

/// A convex body about the origin of its frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Core {
    /// A box of these half extents (m, >= 0): with none a point, with one a segment.
    Box(Vector3<f64>),
    /// A cylinder, cone or truncated cone along z.
    Frustum {
        /// Radius at `-half_height` (m, >= 0).
        bottom: f64,
        /// Radius at `half_height` (m, >= 0).
        top: f64,
        /// m, > 0.
        half_height: f64,
    },
    /// The convex hull of points.
    Hull(Arc<Hull>),
}

/// A convex body grown by a radius, at a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Pose of the core in the base frame, m.
    pub pose: Isometry3<f64>,
    /// The shape without the radius.
    pub core: Core,
    /// Distance of the surface from the core, m, >= 0.
    pub radius: f64,
}

impl Obstacle {
    /// A box of these half extents (m) grown by a radius (m).
    pub fn rounded_box(pose: Isometry3<f64>, half_extents: Vector3<f64>, radius: f64) -> Self {
        Self {
            pose,
            core: Core::Box(half_extents),
            radius,
        }
    }

    /// A sphere at `center` (base frame, m).
    pub fn sphere(center: Vector3<f64>, radius: f64) -> Self {
        let pose = Isometry3::from_parts(center.into(), UnitQuaternion::identity());
        Self::rounded_box(pose, Vector3::zeros(), radius)
    }

    /// A capsule: all points within `radius` of the segment `pt1`-`pt2` (base frame, m).
    pub fn capsule(pt1: Vector3<f64>, pt2: Vector3<f64>, radius: f64) -> Self {
        let along = pt2 - pt1;
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along)
            .unwrap_or_else(UnitQuaternion::identity);
        let pose = Isometry3::from_parts(((pt1 + pt2) * 0.5).into(), turn);
        Self::rounded_box(pose, Vector3::new(0.0, 0.0, 0.5 * along.norm()), radius)
    }

    /// A cuboid with these side lengths (m), centred on `pose` (base frame).
    pub fn cuboid(pose: Isometry3<f64>, side_lengths: Vector3<f64>) -> Self {
        Self::rounded_box(pose, side_lengths * 0.5, 0.0)
    }

    /// A cylinder along the z axis of `pose`, the pose of its centre.
    pub fn cylinder(pose: Isometry3<f64>, radius: f64, height: f64) -> Self {
        Self::frustum(pose, radius, radius, height)
    }

    /// A cone along the z axis of `pose`, the pose of the middle of its height; its tip points
    /// along z.
    pub fn cone(pose: Isometry3<f64>, radius: f64, height: f64) -> Self {
        Self::frustum(pose, radius, 0.0, height)
    }

    /// A truncated cone along the z axis of `pose`, the pose of the middle of its height.
    pub fn frustum(pose: Isometry3<f64>, bottom: f64, top: f64, height: f64) -> Self {
        let half_height = 0.5 * height;
        Self {
            pose,
            core: Core::Frustum {
                bottom,
                top,
                half_height,
            },
            radius: 0.0,
        }
    }

    /// The convex hull of `points` (m) in the frame of `pose`.
    ///
    /// # Errors
    /// [`ObstacleError::Hull`], see [`Hull::new`].
    pub fn hull(pose: Isometry3<f64>, points: &[Vector3<f64>]) -> Result<Self, ObstacleError> {
        Ok(Self {
            pose,
            core: Core::Hull(Arc::new(Hull::new(points)?)),
            radius: 0.0,
        })
    }

    /// Half extents of a box around the core, centred on the middle of the core (m).
    pub fn half_extents(&self) -> Vector3<f64> {
        match &self.core {
            Core::Box(half) => *half,
            Core::Frustum {
                bottom,
                top,
                half_height,
            } => {
                let widest = bottom.max(*top);
                Vector3::new(widest, widest, *half_height)
            }
            Core::Hull(hull) => hull.half_extents(),
        }
    }

    /// Signed distance of a point (base frame) from the surface (m): exact outside of boxes
    /// and frusta, to the nearest face inside of them; for hulls that to the farthest of the
    /// planes of its faces, which is less than the exact one beyond edges and corners.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        let local = self.pose.inverse_transform_point(point).coords;
        let to_core = match &self.core {
            Core::Box(half) => {
                let over = local.abs() - half;
                over.sup(&Vector3::zeros()).norm() + over.max().min(0.0)
            }
            Core::Frustum {
                bottom,
                top,
                half_height,
            } => frustum([*bottom, *top, *half_height], &local),
            Core::Hull(hull) => hull.distance(&local),
        };
        to_core - self.radius
    }

    /// Checks sizes and pose.
    ///
    /// # Errors
    /// [`ObstacleError::Size`] or [`ObstacleError::Pose`].
    pub fn validate(&self) -> Result<(), ObstacleError> {
        let (sizes, grown): ([f64; 3], bool) = match &self.core {
            Core::Box(half) => ((*half).into(), half.max() > 0.0),
            Core::Frustum {
                bottom,
                top,
                half_height,
            } => (
                [*bottom, *top, *half_height],
                bottom.max(*top) > 0.0 && *half_height > 0.0,
            ),
            Core::Hull(hull) => (hull.half_extents().into(), true),
        };
        let mut all = sizes.iter().chain([&self.radius]);
        let valid = all.all(|s| s.is_finite() && *s >= 0.0);
        let is_point = matches!(self.core, Core::Box(_)) && self.radius > 0.0;
        if !valid || !(grown || is_point) {
            return Err(ObstacleError::Size {
                sizes,
                radius: self.radius,
            });
        }
        check_pose(&self.pose)
    }
}

impl Core {
    /// Centre of the box around it, in its own frame (m).
    pub(crate) fn middle(&self) -> Vector3<f64> {
        match self {
            Self::Hull(hull) => hull.middle(),
            Self::Box(_) | Self::Frustum { .. } => Vector3::zeros(),
        }
    }
}

/// In the plane through the axis and the point: the distance from the end or the side,
/// whichever is nearer.
fn frustum([bottom, top, half_height]: [f64; 3], local: &Vector3<f64>) -> f64 {
    let at = Vector2::new(local.xy().norm(), local.z);
    let end = if at.y < 0.0 { bottom } else { top };
    let to_end = Vector2::new(at.x - at.x.min(end), at.y.abs() - half_height);
    let (corner, slope) = (
        Vector2::new(top, half_height),
        Vector2::new(top - bottom, 2.0 * half_height),
    );
    let along = ((corner - at).dot(&slope) / slope.norm_squared()).clamp(0.0, 1.0);
    let to_side = at - corner + slope * along;
    let nearest = to_end.norm_squared().min(to_side.norm_squared()).sqrt();
    if to_side.x < 0.0 && to_end.y < 0.0 {
        -nearest
    } else {
        nearest
    }
}

pub(crate) fn check_pose(pose: &Isometry3<f64>) -> Result<(), ObstacleError> {
    // Far beyond any cell: such a pose is an error.
    let far = 1e6;
    let unit = (pose.rotation.coords.norm() - 1.0).abs() < 1e-6;
    let near = pose.translation.vector.iter().all(|x| x.abs() < far);
    if unit && near {
        Ok(())
    } else {
        Err(ObstacleError::Pose)
    }
}
