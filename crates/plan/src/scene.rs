//! What an arm must not touch.

use nalgebra::Isometry3;
use rmp::Obstacle;

/// A solid body at rest, base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Solid {
    /// A sphere, capsule, cuboid or rounded box.
    Rounded(Obstacle),
    /// A cylinder along the z axis of its pose.
    Cylinder {
        /// Pose of its centre.
        pose: Isometry3<f64>,
        /// Radius (m), > 0.
        radius: f64,
        /// Full height (m), > 0.
        height: f64,
    },
}

impl Solid {
    /// Signed distance of a point from the surface (m), exact outside; inside of a box or a
    /// cylinder the distance to the nearest face, negative.
    pub fn distance(&self, point: &nalgebra::Point3<f64>) -> f64 {
        match self {
            Self::Rounded(obstacle) => {
                let local = obstacle.pose.inverse_transform_point(point).coords.abs();
                let over = local - obstacle.half_extents;
                let outside = over.sup(&nalgebra::Vector3::zeros()).norm();
                outside + over.max().min(0.0) - obstacle.radius
            }
            Self::Cylinder {
                pose,
                radius,
                height,
            } => {
                let local = pose.inverse_transform_point(point);
                let (aside, along) = (
                    local.coords.xy().norm() - radius,
                    local.z.abs() - 0.5 * height,
                );
                aside.max(0.0).hypot(along.max(0.0)) + aside.max(along).min(0.0)
            }
        }
    }

    fn is_valid(&self) -> bool {
        match self {
            Self::Rounded(obstacle) => obstacle.validate().is_ok(),
            Self::Cylinder {
                pose,
                radius,
                height,
            } => {
                let core = Obstacle {
                    pose: *pose,
                    half_extents: nalgebra::Vector3::new(*radius, *radius, 0.5 * height),
                    radius: 0.0,
                };
                core.validate().is_ok() && *radius > 0.0 && *height > 0.0
            }
        }
    }
}

/// Solids as they are checked.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    pub(crate) solids: Vec<Prepared>,
}

/// A solid in single precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prepared {
    pub(crate) center: [f32; 3],
    /// World to local, row by row.
    pub(crate) rows: [[f32; 3]; 3],
    pub(crate) half: [f32; 3],
    /// Beyond the core (m).
    pub(crate) radius: f32,
    pub(crate) is_cylinder: bool,
}

impl Scene {
    /// Of solids; `None` where one has a size or a pose that is none.
    pub fn new(solids: &[Solid]) -> Option<Self> {
        if !solids.iter().all(Solid::is_valid) {
            return None;
        }
        let solids = solids.iter().map(prepared).collect();
        Some(Self { solids })
    }
}

#[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}

fn prepared(solid: &Solid) -> Prepared {
    let (pose, half, radius, is_cylinder) = match solid {
        Solid::Rounded(obstacle) => (obstacle.pose, obstacle.half_extents, obstacle.radius, false),
        Solid::Cylinder {
            pose,
            radius,
            height,
        } => {
            let half = nalgebra::Vector3::new(*radius, *radius, 0.5 * height);
            (*pose, half, 0.0, true)
        }
    };
    let rotation = pose.rotation.to_rotation_matrix();
    let row = |axis: usize| {
        let column = rotation.matrix().column(axis);
        [single(column[0]), single(column[1]), single(column[2])]
    };
    let at = pose.translation.vector;
    Prepared {
        center: [single(at.x), single(at.y), single(at.z)],
        rows: [row(0), row(1), row(2)],
        half: [single(half.x), single(half.y), single(half.z)],
        radius: single(radius),
        is_cylinder,
    }
}
