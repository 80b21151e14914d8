//! The load that a held object carries: its weight and that of all objects upon it.

use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

use crate::engine::convert;
use crate::engine::settings::GRAVITY;
use crate::engine::tag::Tag;

/// `object` and all objects that touch it or one another; `None` where one of them
/// touches something else, which may carry a part of it.
pub(crate) fn with(
    engine: &PhysicsWorld,
    objects: &[RigidBodyHandle],
    object: usize,
) -> Option<Vec<usize>> {
    let mut reached = vec![object];
    let mut next = 0;
    while let Some(&object) = reached.get(next) {
        next += 1;
        for tag in touching(engine, *objects.get(object)?) {
            match tag {
                Tag::Object(other) if !reached.contains(&other) => reached.push(other),
                Tag::Object(_) => {}
                Tag::Fixture(_) | Tag::Link { .. } => return None,
            }
        }
    }
    Some(reached)
}

/// Force (N) and torque about `cup` (N·m, world frame) at rest of `object` and of
/// all that hangs with it; `None` where something else may carry a part of it.
pub(crate) fn load(
    engine: &PhysicsWorld,
    objects: &[RigidBodyHandle],
    object: usize,
    cup: &Vector3<f64>,
) -> Option<(f64, f64)> {
    let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
    for object in with(engine, objects, object)? {
        let body = engine.bodies.get(*objects.get(object)?)?;
        let weight = Vector3::from(GRAVITY) * body.mass();
        force += weight;
        torque += (convert::from_vector(body.center_of_mass()) - cup).cross(&weight);
    }
    Some((force.norm(), torque.norm()))
}

fn touching(engine: &PhysicsWorld, body: RigidBodyHandle) -> Vec<Tag> {
    let colliders = engine
        .bodies
        .get(body)
        .map_or(&[][..], RigidBody::colliders);
    let mut tags = Vec::new();
    for &collider in colliders {
        let pairs = engine.narrow_phase.contact_pairs_with(collider);
        for pair in pairs.filter(|pair| pair.has_any_active_contact()) {
            let other = if pair.collider1 == collider {
                pair.collider2
            } else {
                pair.collider1
            };
            tags.extend(
                engine
                    .colliders
                    .get(other)
                    .map(|c| Tag::decode(c.user_data)),
            );
        }
    }
    tags
}
