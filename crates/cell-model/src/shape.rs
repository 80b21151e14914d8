//! Shapes of links, objects and fixtures. Every shape is centred on its frame;
//! round ones stand along z.

use nalgebra::{Isometry3, Matrix3, Vector3};
use schemars::JsonSchema;
use serde::Deserialize;

/// A convex solid.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A cuboid.
    Box {
        /// Full edge lengths (m).
        size_m: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Radius (m).
        radius_m: f64,
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius (m).
        radius_m: f64,
        /// Full height (m).
        height_m: f64,
    },
    /// A cylinder along z with half balls on both ends.
    Capsule {
        /// Radius (m).
        radius_m: f64,
        /// Height of the cylindrical part (m).
        height_m: f64,
    },
}

impl Shape {
    /// Every length of the shape, with its key in a file.
    pub fn lengths(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Box { size_m } => size_m.iter().map(|length| ("size_m", *length)).collect(),
            Self::Sphere { radius_m } => vec![("radius_m", radius_m)],
            Self::Cylinder { radius_m, height_m } | Self::Capsule { radius_m, height_m } => {
                vec![("radius_m", radius_m), ("height_m", height_m)]
            }
        }
    }

    /// Radius of the ball around the centre that holds the shape (m).
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Self::Box { size_m: [x, y, z] } => 0.5 * (x * x + y * y + z * z).sqrt(),
            Self::Sphere { radius_m } => radius_m,
            Self::Cylinder { radius_m, height_m } => {
                (radius_m * radius_m + 0.25 * height_m * height_m).sqrt()
            }
            Self::Capsule { radius_m, height_m } => radius_m + 0.5 * height_m,
        }
    }
}

/// A shape on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkShape {
    /// The shape.
    pub shape: Shape,
    /// Its pose in the link frame.
    pub pose: Isometry3<f64>,
}

/// A rigid body of a robot: the base, or the child of one joint with
/// everything that is fixed to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name of the URDF link that moves with the joint.
    pub name: String,
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass in the link frame (m).
    pub center_of_mass: Vector3<f64>,
    /// Inertia about the centre of mass, axes of the link frame (kg·m²).
    pub inertia: Matrix3<f64>,
    /// Collision shapes.
    pub shapes: Vec<LinkShape>,
}

impl Link {
    /// Adds a body that is rigidly fixed to this one at `pose` (of the body's
    /// frame in this link's frame): parallel-axis theorem.
    pub(crate) fn absorb(&mut self, body: &Link, pose: &Isometry3<f64>) {
        let shapes = body.shapes.iter();
        self.shapes.extend(shapes.map(|s| LinkShape {
            shape: s.shape.clone(),
            pose: pose * s.pose,
        }));
        if body.mass <= 0.0 {
            return;
        }
        let rotation = pose.rotation.to_rotation_matrix();
        let center = pose.translation.vector + rotation * body.center_of_mass;
        let inertia = rotation.matrix() * body.inertia * rotation.matrix().transpose();
        let mass = self.mass + body.mass;
        let merged = (self.center_of_mass * self.mass + center * body.mass) / mass;
        self.inertia += steiner(self.mass, self.center_of_mass - merged)
            + inertia
            + steiner(body.mass, center - merged);
        self.center_of_mass = merged;
        self.mass = mass;
    }
}

/// Inertia of a point mass at `offset` (kg·m²).
fn steiner(mass: f64, offset: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * offset.norm_squared() - offset * offset.transpose()) * mass
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_point_masses_make_a_dumbbell() {
        let point = |name: &str| Link {
            name: name.to_owned(),
            mass: 1.0,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::zeros(),
            shapes: vec![],
        };
        let mut link = point("a");
        link.absorb(&point("b"), &Isometry3::translation(2.0, 0.0, 0.0));
        assert_eq!(link.center_of_mass, Vector3::new(1.0, 0.0, 0.0));
        assert_eq!(
            link.inertia,
            Matrix3::from_diagonal(&Vector3::new(0.0, 2.0, 2.0))
        );
    }
}
