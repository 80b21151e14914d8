//! Shapes of links, objects and fixtures. Every shape is centred on its frame; the axis of
//! round ones is z, and bins open towards z.

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};
use rmp::Obstacle;
use schemars::JsonSchema;
use serde::Deserialize;

/// A solid, convex but for the bin.
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
    /// An open box: a floor and four walls.
    Bin {
        /// Outer edge lengths (m).
        size_m: [f64; 3],
        /// Thickness of floor and walls (m).
        wall_m: f64,
    },
}

/// A cuboid of a bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    /// Full edge lengths (m).
    pub size: Vector3<f64>,
    /// Its centre in the bin's frame (m).
    pub centre: Vector3<f64>,
}

impl Shape {
    /// Floor, the two walls along y at -x and +x, and the two between them at -y and +y; `None`
    /// for other shapes. They touch and do not overlap.
    pub fn panels(&self) -> Option<[Panel; 5]> {
        let Self::Bin { size_m, wall_m } = *self else {
            return None;
        };
        let [x, y, z] = size_m;
        let (inner_x, wall_z) = (x - 2.0 * wall_m, z - wall_m);
        let panel = |size: [f64; 3], centre: [f64; 3]| Panel {
            size: size.into(),
            centre: centre.into(),
        };
        let (at_x, at_y, up) = (0.5 * (x - wall_m), 0.5 * (y - wall_m), 0.5 * wall_m);
        Some([
            panel([x, y, wall_m], [0.0, 0.0, 0.5 * (wall_m - z)]),
            panel([wall_m, y, wall_z], [-at_x, 0.0, up]),
            panel([wall_m, y, wall_z], [at_x, 0.0, up]),
            panel([inner_x, wall_m, wall_z], [0.0, -at_y, up]),
            panel([inner_x, wall_m, wall_z], [0.0, at_y, up]),
        ])
    }

    /// The parts of the shape at `pose` that motions avoid: floor and walls of a bin, and the
    /// shape itself otherwise.
    pub fn obstacles(&self, pose: Isometry3<f64>) -> Vec<Obstacle> {
        let Some(panels) = self.panels() else {
            return vec![self.obstacle(pose)];
        };
        let at = |panel: &Panel| pose * Translation3::from(panel.centre);
        let panels = panels.iter();
        panels
            .map(|panel| Obstacle::cuboid(at(panel), panel.size))
            .collect()
    }

    /// The shape at `pose` as one solid; a bin counts as full.
    pub fn obstacle(&self, pose: Isometry3<f64>) -> Obstacle {
        match *self {
            Self::Box { size_m } | Self::Bin { size_m, .. } => {
                Obstacle::cuboid(pose, Vector3::from(size_m))
            }
            Self::Sphere { radius_m } => Obstacle::rounded_box(pose, Vector3::zeros(), radius_m),
            Self::Cylinder { radius_m, height_m } => Obstacle::cylinder(pose, radius_m, height_m),
            Self::Capsule { radius_m, height_m } => {
                Obstacle::rounded_box(pose, Vector3::new(0.0, 0.0, 0.5 * height_m), radius_m)
            }
        }
    }

    /// Every length of the shape, with its key in a file.
    pub fn lengths(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Box { size_m } => size_m.iter().map(|length| ("size_m", *length)).collect(),
            Self::Sphere { radius_m } => vec![("radius_m", radius_m)],
            Self::Cylinder { radius_m, height_m } | Self::Capsule { radius_m, height_m } => {
                vec![("radius_m", radius_m), ("height_m", height_m)]
            }
            Self::Bin { size_m, wall_m } => size_m
                .iter()
                .map(|length| ("size_m", *length))
                .chain([("wall_m", wall_m)])
                .collect(),
        }
    }

    /// Radius of the ball around the centre that encloses the shape (m).
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Self::Box { size_m: [x, y, z] }
            | Self::Bin {
                size_m: [x, y, z], ..
            } => 0.5 * (x * x + y * y + z * z).sqrt(),
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

/// A rigid body of a robot: the base, or the child of one joint with everything fixed to it.
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
    /// Adds a body that is fixed to this one at `pose` (the body's frame in this link's frame),
    /// by the parallel axis theorem.
    pub(crate) fn absorb(&mut self, body: &Link, pose: &Isometry3<f64>) {
        let shapes = body.shapes.iter();
        self.shapes.extend(shapes.map(|s| LinkShape {
            shape: s.shape.clone(),
            pose: pose * s.pose,
        }));
        // Without mass the common centre of two bodies without mass would be 0 / 0.
        if body.mass > 0.0 {
            self.add_mass(body, pose, 1.0);
        }
    }

    /// This body without the mass of a part that is fixed to it at `pose` (the part's frame in this
    /// link's frame); `None` unless the part is lighter. The shapes stay.
    pub fn without(&self, part: &Link, pose: &Isometry3<f64>) -> Option<Self> {
        let mut rest = self.clone();
        (part.mass < self.mass).then(|| rest.add_mass(part, pose, -1.0))?;
        Some(rest)
    }

    /// Adds the mass of `body`, or subtracts it with the sign -1.
    fn add_mass(&mut self, body: &Link, pose: &Isometry3<f64>, sign: f64) {
        let rotation = pose.rotation.to_rotation_matrix();
        let center = pose.translation.vector + rotation * body.center_of_mass;
        let inertia = rotation.matrix() * body.inertia * rotation.matrix().transpose();
        let added = sign * body.mass;
        let mass = self.mass + added;
        let merged = (self.center_of_mass * self.mass + center * added) / mass;
        self.inertia += steiner(self.mass, self.center_of_mass - merged)
            + inertia * sign
            + steiner(added, center - merged);
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
    fn the_panels_of_a_bin_fill_its_outside_and_leave_its_inside() {
        let size_m = [0.3, 0.2, 0.14];
        let wall_m = 0.005;
        let panels = Shape::Bin { size_m, wall_m }.panels().unwrap();
        let volume: f64 = panels.iter().map(|panel| panel.size.product()).sum();
        let inside = 0.29 * 0.19 * 0.135;
        assert!((volume - (0.3 * 0.2 * 0.14 - inside)).abs() < 1.0e-12);
        for panel in panels {
            let reach = panel.centre.abs() + 0.5 * panel.size;
            assert!(
                reach
                    .iter()
                    .zip(size_m)
                    .all(|(r, s)| *r <= 0.5 * s + 1.0e-12)
            );
        }
    }

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
