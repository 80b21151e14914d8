//! A movable object of the cell.

use std::f64::consts::TAU;

use cell_model::{ObjectSpec, Shape};
use ipc_types::Pose;
use nalgebra::{UnitQuaternion, Vector3};

use crate::geometry;
use crate::pose::about;

/// Sides whose lengths differ by less are equal (m): a quarter turn makes no difference.
const EQUAL_M: f64 = 0.001;
/// An object tilted by less rests as it shall (rad).
pub(crate) const LEVEL_RAD: f64 = 0.1;

/// A movable object of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSetup {
    /// Its name in the cell file.
    pub name: String,
    /// Half of its height when it is upright (m).
    pub half_height_m: f64,
    /// Its narrowest side (m).
    pub narrowest_m: f64,
    /// Its longest side (m).
    pub longest_m: f64,
    /// Its mass (kg).
    pub mass_kg: f64,
    /// Bit of [`ipc_types::ArmGoal::object_mask`], for one that is an obstacle.
    pub obstacle_bit: Option<u32>,
    shape: Shape,
}

impl ObjectSetup {
    /// The setup of `spec`.
    pub fn of(spec: &ObjectSpec) -> Self {
        let sides = sides(&spec.shape);
        Self {
            name: spec.name.clone(),
            half_height_m: 0.5 * sides.z,
            narrowest_m: sides.min(),
            longest_m: sides.max(),
            mass_kg: spec.mass,
            obstacle_bit: None,
            shape: spec.shape.clone(),
        }
    }

    /// The axis of its body (0 x, 1 y, 2 z) that is nearest to the vertical.
    fn vertical_axis(rotation: &UnitQuaternion<f64>) -> usize {
        let up = rotation.inverse() * Vector3::z();
        // Of equal ones z: it is the one of an upright object.
        [2, 1, 0].into_iter().fold(2, |best, axis| {
            if up[axis].abs() > up[best].abs() {
                axis
            } else {
                best
            }
        })
    }

    /// Half of its height at `pose`, with the body axis vertical that is nearest to it (m).
    pub fn half_height_at(&self, pose: &Pose) -> f64 {
        let rotation = geometry::rotation(pose.orientation_wxyz);
        0.5 * sides(&self.shape)[Self::vertical_axis(&rotation)]
    }

    /// Angle to the nearest pose at rest: on a side, or a round one with its axis upright or level
    /// (rad, 0 to about 1).
    pub fn tilt(&self, pose: &Pose) -> f64 {
        let up = geometry::rotation(pose.orientation_wxyz).inverse() * Vector3::z();
        let along = match self.shape {
            Shape::Sphere { .. } => return 0.0,
            // Along the axis, or at a right angle to it.
            Shape::Cylinder { .. } | Shape::Capsule { .. } => {
                up.z.abs().max(libm::hypot(up.x, up.y))
            }
            Shape::Box { .. } | Shape::Bin { .. } => up.amax(),
        };
        libm::acos(along.min(1.0))
    }

    /// Rotations at a turn of `yaw` about the vertical (rad) that look the same, upright or level
    /// as it is nearest to now; of a shape that is round about the vertical, turned from
    /// `rotation`.
    pub(crate) fn at_rest(
        &self,
        rotation: &UnitQuaternion<f64>,
        yaw: f64,
    ) -> impl Iterator<Item = UnitQuaternion<f64>> + use<> {
        let level = |v: Vector3<f64>| Vector3::new(v.x, v.y, 0.0);
        let vertical = Self::vertical_axis(rotation);
        let axis = rotation * Vector3::ith(vertical, 1.0);
        let up = straightened(rotation, axis, Vector3::new(0.0, 0.0, axis.z.signum()));
        // Its rotation without a tilt, the body axis that `yaw` turns, and the number of turns.
        let (straight, heading, count) = match self.shape {
            Shape::Sphere { .. } => (*rotation, None, 8),
            Shape::Cylinder { .. } | Shape::Capsule { .. } if vertical == 2 => (up, None, 8),
            Shape::Cylinder { .. } | Shape::Capsule { .. } => {
                let along = rotation * Vector3::z();
                let straight = straightened(rotation, along, level(along));
                (straight, Some(Vector3::z()), 2)
            }
            Shape::Box { .. } | Shape::Bin { .. } => {
                let sides = sides(&self.shape);
                let (a, b) = ((vertical + 1) % 3, (vertical + 2) % 3);
                let is_square = (sides[a] - sides[b]).abs() < EQUAL_M;
                (
                    up,
                    Some(Vector3::ith(a, 1.0)),
                    if is_square { 4 } else { 2 },
                )
            }
        };
        let first = heading.map_or(0.0, |axis| {
            let now = straight * axis;
            yaw - libm::atan2(now.y, now.x)
        });
        let step = TAU / f64::from(count);
        (0..count).map(move |turn| about(Vector3::z(), first + f64::from(turn) * step) * straight)
    }
}

/// `rotation`, turned the short way so that its direction `from` becomes `to`.
fn straightened(
    rotation: &UnitQuaternion<f64>,
    from: Vector3<f64>,
    to: Vector3<f64>,
) -> UnitQuaternion<f64> {
    let turn = UnitQuaternion::rotation_between(&from, &to);
    turn.unwrap_or_else(UnitQuaternion::identity) * rotation
}

/// Lengths of a shape along the axes of its body (m).
fn sides(shape: &Shape) -> Vector3<f64> {
    let round = |radius: f64, height: f64| Vector3::new(2.0 * radius, 2.0 * radius, height);
    match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => size_m.into(),
        Shape::Sphere { radius_m } => round(radius_m, 2.0 * radius_m),
        Shape::Cylinder { radius_m, height_m } => round(radius_m, height_m),
        Shape::Capsule { radius_m, height_m } => round(radius_m, height_m + 2.0 * radius_m),
    }
}
