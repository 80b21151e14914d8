//! Contacts of an arm, for the checks of its path.

use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

use crate::arm::multibody::Arm;
use crate::engine::contacts::partner;
use crate::engine::convert;
use crate::engine::tag::Tag;

/// Largest distance behind the plane of the cup at which a contact is one of its rim (m): at
/// the 15 degrees that a cup follows, its rim is this much above its lowest point, with a
/// margin.
const RIM_M: f64 = 0.012;

/// The body that a link touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touched {
    /// A fixture, by its place among those of the cell that are solid.
    Fixture(usize),
    /// An object by its place in the cell.
    Object(usize),
    /// A link of another arm.
    Arm(usize),
}

/// One link of an arm and something it touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmContact {
    /// The link: 1 is the child of the first joint, the last one has the tool.
    pub link: usize,
    /// The other body.
    pub with: Touched,
    /// Only the suction cup's face touches it, not the tube it sits on nor the
    /// wrist.
    pub at_cup: bool,
    /// Deepest point (m, world frame).
    pub point: [f64; 3],
    /// Depth there (m); negative while the shapes are only near, 2 mm at most.
    pub depth: f64,
}

/// Contacts of all links of `arm` except its base, which is mounted on something. The object
/// on the cup does not touch the link of the tool in the engine.
pub(crate) fn of(world: &PhysicsWorld, index: usize, arm: &Arm) -> Vec<ArmContact> {
    let mut contacts = Vec::new();
    for (link, body) in arm.bodies.iter().enumerate().skip(1) {
        let body = world.bodies.get(*body);
        for &own in body.map_or(&[][..], RigidBody::colliders) {
            for pair in world.narrow_phase.contact_pairs_with(own) {
                let with = other(world, index, pair, own);
                contacts.extend(with.and_then(|with| contact(world, arm, link, with, pair)));
            }
        }
    }
    contacts
}

fn other(
    world: &PhysicsWorld,
    arm: usize,
    pair: &ContactPair,
    own: ColliderHandle,
) -> Option<Touched> {
    let handle = partner(pair, own);
    let collider = world.colliders.get(handle)?;
    match Tag::decode(collider.user_data) {
        Tag::Object(object) => Some(Touched::Object(object)),
        Tag::Link { arm: other, .. } => (other != arm).then_some(Touched::Arm(other)),
        Tag::Fixture(_) => {
            let ground = world.bodies.get(collider.parent()?)?;
            let place = ground.colliders().iter().position(|c| *c == handle)?;
            Some(Touched::Fixture(place))
        }
    }
}

fn contact(
    world: &PhysicsWorld,
    arm: &Arm,
    link: usize,
    with: Touched,
    pair: &ContactPair,
) -> Option<ArmContact> {
    let first = world.colliders.get(pair.collider1)?;
    let (mut deepest, mut behind) = (None::<(f64, Vector3<f64>)>, 0.0_f64);
    let tcp = arm.tcp(world);
    let axis = arm.robot.suction.as_ref().map(|s| tcp.rotation * s.axis);
    // A manifold without solver contacts is near, and not in contact.
    let active = |m: &&ContactManifold| !m.data.solver_contacts.is_empty();
    for manifold in pair.manifolds().iter().filter(active) {
        for point in &manifold.points {
            // Points of a compound are in the frame of the part.
            let local = match manifold.subshape_pos1() {
                Some(part) => *part * point.local_p1,
                None => point.local_p1,
            };
            let at = convert::from_vector(*first.position() * local);
            if let Some(axis) = &axis {
                behind = behind.max(-(at - tcp.translation.vector).dot(axis));
            }
            if deepest.is_none_or(|(depth, _)| -point.dist > depth) {
                deepest = Some((-point.dist, at));
            }
        }
    }
    let tool = arm.bodies.len() - 1;
    deepest.map(|(depth, point)| ArmContact {
        link,
        with,
        at_cup: axis.is_some() && link == tool && behind <= RIM_M,
        point: point.into(),
        depth,
    })
}
