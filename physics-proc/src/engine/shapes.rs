//! Shapes of the model as shapes of the engine.

use cell_model::Shape;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::shape::SharedShape;

use crate::engine::convert;

/// The shape of the engine, and its pose in the frame of the shape of the model.
pub fn shared(shape: &Shape) -> (SharedShape, Isometry3<f64>) {
    match *shape {
        Shape::Box { size_m: [x, y, z] } => (
            SharedShape::cuboid(0.5 * x, 0.5 * y, 0.5 * z),
            Isometry3::identity(),
        ),
        Shape::Sphere { radius_m } => (SharedShape::ball(radius_m), Isometry3::identity()),
        Shape::Cylinder { radius_m, height_m } => {
            (SharedShape::cylinder(0.5 * height_m, radius_m), upright())
        }
        Shape::Capsule { radius_m, height_m } => (
            SharedShape::capsule_z(0.5 * height_m, radius_m),
            Isometry3::identity(),
        ),
        Shape::Bin { .. } => (bin(shape), Isometry3::identity()),
    }
}

/// One compound of five cuboids: as five colliders a bin buzzes.
fn bin(shape: &Shape) -> SharedShape {
    let panels = shape.panels().into_iter().flatten();
    let parts = panels.map(|panel| {
        let half = 0.5 * panel.size;
        let pose = Isometry3::from_parts(panel.centre.into(), UnitQuaternion::identity());
        (
            convert::to_pose(&pose),
            SharedShape::cuboid(half.x, half.y, half.z),
        )
    });
    SharedShape::compound(parts.collect())
}

/// Turns the engine's y axis to z.
fn upright() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    Isometry3::from_parts(Translation3::identity(), turn)
}

/// Depth by which two shapes at poses in the world overlap (m); 0 if they do not. Shapes that
/// parry cannot compare count as apart.
pub(crate) fn overlap(a: &Shape, at_a: &Isometry3<f64>, b: &Shape, at_b: &Isometry3<f64>) -> f64 {
    let ((shape_a, own_a), (shape_b, own_b)) = (shared(a), shared(b));
    let (pose_a, pose_b) = (
        convert::to_pose(&(at_a * own_a)),
        convert::to_pose(&(at_b * own_b)),
    );
    let contact = parry3d_f64::query::contact(
        &pose_a,
        shape_a.0.as_ref(),
        &pose_b,
        shape_b.0.as_ref(),
        0.0,
    );
    contact
        .ok()
        .flatten()
        .map_or(0.0, |contact| (-contact.dist).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cylinders_stand_upright() {
        let tower = Shape::Cylinder {
            radius_m: 0.1,
            height_m: 2.0,
        };
        let ball = Shape::Sphere { radius_m: 0.05 };
        let at = |z: f64| Isometry3::translation(0.0, 0.0, z);
        assert!(overlap(&tower, &at(0.0), &ball, &at(0.99)) > 0.05);
        assert_eq!(overlap(&tower, &at(0.0), &ball, &at(1.06)), 0.0);
        assert_eq!(
            overlap(
                &tower,
                &at(0.0),
                &ball,
                &Isometry3::translation(0.2, 0.0, 0.0)
            ),
            0.0
        );
    }
}
