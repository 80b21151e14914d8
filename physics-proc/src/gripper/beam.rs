//! The light barrier of a parallel gripper: a ray from pad to pad through the tool centre
//! point, as such hands have it to detect a part.

use nalgebra::Vector3;
use parry3d_f64::query::Ray;
use rapier3d_f64::prelude::*;

use crate::arm::multibody::Arm;
use crate::engine::convert;

/// The object that interrupts the beam of `arm`, nearest to the first finger;
/// `width` is the distance of the pads (m).
pub(crate) fn interrupted_by(
    arm: &Arm,
    engine: &PhysicsWorld,
    objects: &[RigidBodyHandle],
    width: f64,
) -> Option<usize> {
    let gripper = arm.robot().gripper.as_ref()?;
    let finger = |joint: usize| {
        let body = engine.bodies.get(*arm.bodies().get(joint + 1)?)?;
        Some(convert::from_pose(body.position()).translation.vector)
    };
    let [first, second] = gripper.finger_joints;
    // The fingers are side by side, so their origins give the closing axis. If they meet no
    // part fits between them.
    let axis = (finger(second)? - finger(first)?).try_normalize(1.0e-4)?;
    let start = arm.tcp(engine).translation.vector - axis * (0.5 * width);
    let finite = |v: &Vector3<f64>| v.iter().all(|x: &f64| x.is_finite());
    if !(finite(&start) && width > 0.0) {
        return None;
    }
    let ray = Ray::new(convert::to_vector(&start), convert::to_vector(&axis));
    let hit = |handle: &RigidBodyHandle| {
        let colliders = engine.bodies.get(*handle)?.colliders().iter();
        let distances = colliders.filter_map(|c| {
            let collider = engine.colliders.get(*c)?;
            let shape = collider.shape();
            shape.cast_ray(collider.position(), &ray, width, true)
        });
        distances.min_by(f64::total_cmp)
    };
    let hits = objects.iter().enumerate();
    hits.filter_map(|(index, handle)| Some((index, hit(handle)?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}
