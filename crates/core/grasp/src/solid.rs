//! Bodies as convex parts, and how near they are to each other.

use cell_model::Shape;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::SharedShape;

/// A convex part, in the frame of its body.
#[derive(Clone)]
struct Part {
    shape: SharedShape,
    pose: Isometry3<f64>,
    /// Radius of a ball about its origin that contains it (m).
    radius: f64,
}

/// A rigid body of convex parts.
#[derive(Clone, Default)]
pub struct Solid(Vec<Part>);

impl Solid {
    /// The body of `shape`; a bin has five parts.
    pub fn of(shape: &Shape) -> Self {
        let mut solid = Self::default();
        solid.add(shape, &Isometry3::identity());
        solid
    }

    /// Adds `shape` at `pose` in the frame of the body.
    pub fn add(&mut self, shape: &Shape, pose: &Isometry3<f64>) {
        let cuboid =
            |size: Vector3<f64>| SharedShape::cuboid(0.5 * size.x, 0.5 * size.y, 0.5 * size.z);
        match *shape {
            Shape::Box { size_m } => {
                let size = Vector3::from(size_m);
                self.push(cuboid(size), *pose, 0.5 * size.norm());
            }
            Shape::Sphere { radius_m } => self.push(SharedShape::ball(radius_m), *pose, radius_m),
            Shape::Cylinder { radius_m, height_m } => {
                let shape = SharedShape::cylinder(0.5 * height_m, radius_m);
                self.push(shape, pose * upright(), radius_m.hypot(0.5 * height_m));
            }
            Shape::Capsule { radius_m, height_m } => {
                let shape = SharedShape::capsule_z(0.5 * height_m, radius_m);
                self.push(shape, *pose, radius_m + 0.5 * height_m);
            }
            Shape::Bin { .. } => {
                for panel in shape.panels().into_iter().flatten() {
                    let at = pose * Translation3::from(panel.centre);
                    self.push(cuboid(panel.size), at, 0.5 * panel.size.norm());
                }
            }
        }
    }

    fn push(&mut self, shape: SharedShape, pose: Isometry3<f64>, radius: f64) {
        self.0.push(Part {
            shape,
            pose,
            radius,
        });
    }

    /// Whether the body at `at` is nearer than `margin` (m) to `other` at `other_at`.
    pub fn is_near(
        &self,
        at: &Isometry3<f64>,
        other: &Self,
        other_at: &Isometry3<f64>,
        margin: f64,
    ) -> bool {
        self.0.iter().any(|part| {
            let pose = at * part.pose;
            other.0.iter().any(|its| {
                let its_pose = other_at * its.pose;
                // The enclosing balls first: they exclude distant pairs without an exact distance.
                let apart = (pose.translation.vector - its_pose.translation.vector).norm();
                apart < part.radius + its.radius + margin
                    && distance(&part.shape, &pose, &its.shape, &its_pose) < margin
            })
        })
    }

    /// Distance of the body at `at` from `point` (m); 0 inside of it.
    pub fn distance_to(&self, at: &Isometry3<f64>, point: &Point3<f64>) -> f64 {
        let distances = self.0.iter().map(|part| {
            let local = (at * part.pose).inverse_transform_point(point);
            part.shape
                .distance_to_local_point(vector(&local.coords), true)
        });
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Radius of a ball about its origin that contains it (m).
    pub(crate) fn radius(&self) -> f64 {
        let reach = |part: &Part| part.pose.translation.vector.norm() + part.radius;
        self.0.iter().map(reach).fold(0.0, f64::max)
    }

    /// The least and the largest coordinate of the body at `at` along a unit `axis` (m).
    pub fn extent(&self, at: &Isometry3<f64>, axis: &Vector3<f64>) -> (f64, f64) {
        let mut extent = (f64::INFINITY, f64::NEG_INFINITY);
        for part in &self.0 {
            let pose = at * part.pose;
            let local = pose.rotation.inverse() * axis;
            let support = |direction: Vector3<f64>| {
                let map = part.shape.as_support_map()?;
                let point = map.local_support_point(vector(&direction));
                let point = pose * nalgebra::Point3::new(point.x, point.y, point.z);
                Some(point.coords.dot(axis))
            };
            extent.0 = support(-local).map_or(extent.0, |low| extent.0.min(low));
            extent.1 = support(local).map_or(extent.1, |high| extent.1.max(high));
        }
        extent
    }
}

/// Distance of two shapes (m); 0 where they overlap. All pairs of convex shapes are supported.
fn distance(a: &SharedShape, at_a: &Isometry3<f64>, b: &SharedShape, at_b: &Isometry3<f64>) -> f64 {
    let (at_a, at_b) = (to_pose(at_a), to_pose(at_b));
    let found = query::distance(&at_a, a.0.as_ref(), &at_b, b.0.as_ref());
    found.map_or(0.0, |found| found.distance)
}

fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn to_pose(pose: &Isometry3<f64>) -> Pose {
    let q = pose.rotation;
    Pose::from_parts(
        vector(&pose.translation.vector),
        Rotation::from_xyzw(q.i, q.j, q.k, q.w),
    )
}

/// Turns parry's axis of a cylinder, y, to z.
fn upright() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    Isometry3::from_parts(Translation3::identity(), turn)
}
