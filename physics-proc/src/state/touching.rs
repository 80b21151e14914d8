//! Contacts of the bodies, as they are published for people.

use ipc_types::contact::{BodyKind, Contact, MAX_CONTACTS};
use ipc_types::{Contacts, Header};
use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

use crate::engine::convert;
use crate::engine::settings::TICK_S;
use crate::engine::tag::Tag;
use crate::operator::contact_stop::Pressure;

/// Weaker contacts are left out (N).
const LEAST_N: f64 = 0.01;
/// Beyond this a force is an error of the engine, and readers drop the message (N).
const MOST_N: f64 = 1.0e4;

/// Writes the contacts of the last tick, largest force first. Forces are those along
/// the contact normals: the engine does not keep the directions of friction.
pub(crate) fn write(engine: &PhysicsWorld, tick: u64, out: &mut Contacts) {
    let pairs = engine.contact_pairs();
    let mut found: Vec<Contact> = pairs.filter_map(|pair| contact(engine, pair)).collect();
    let size = |contact: &Contact| Vector3::from(contact.force).norm();
    found.sort_by(|one, other| size(other).total_cmp(&size(one)));
    out.header = Header::caused_by::<Contacts>(tick);
    out.total = u32::try_from(found.len()).unwrap_or(u32::MAX);
    // Sorted before the cut: the contacts with the largest forces are kept.
    found.truncate(MAX_CONTACTS);
    out.count = u32::try_from(found.len()).unwrap_or(0);
    for (slot, contact) in out.contacts.iter_mut().zip(found) {
        *slot = contact;
    }
}

/// What presses on arm `arm` and on the object `held` that it holds.
pub(crate) fn pressure(engine: &PhysicsWorld, arm: usize, held: Option<usize>) -> Pressure {
    let own = Contact::body(BodyKind::Arm, arm);
    let held = held.map(|object| Contact::body(BodyKind::Object, object));
    let is_own = |body: u32| body == own || Some(body) == held;
    let mut all = Pressure::default();
    let mut largest_n = 0.0;
    let contacts = engine
        .contact_pairs()
        .filter_map(|pair| contact(engine, pair));
    for contact in contacts.filter(|of| is_own(of.a) != is_own(of.b)) {
        let force = Vector3::from(contact.force);
        all.force += if is_own(contact.a) { force } else { -force };
        if force.norm() > largest_n {
            largest_n = force.norm();
            all.with = if is_own(contact.a) {
                contact.b
            } else {
                contact.a
            };
        }
    }
    all
}

fn contact(engine: &PhysicsWorld, pair: &ContactPair) -> Option<Contact> {
    let first = engine.colliders.get(pair.collider1)?;
    let second = engine.colliders.get(pair.collider2)?;
    let (mut force, mut moment, mut total) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for manifold in pair.manifolds() {
        let normal = convert::from_vector(manifold.data.normal);
        for point in &manifold.points {
            let size = point.data.impulse / TICK_S;
            let local = match manifold.subshape_pos1() {
                Some(part) => *part * point.local_p1,
                None => point.local_p1,
            };
            moment += convert::from_vector(*first.position() * local) * size;
            force -= normal * size;
            total += size;
        }
    }
    let sane = (LEAST_N..MOST_N).contains(&total);
    sane.then(|| Contact {
        a: body(first),
        b: body(second),
        position: (moment / total).into(),
        force: force.into(),
    })
}

fn body(collider: &Collider) -> u32 {
    match Tag::decode(collider.user_data) {
        Tag::Object(object) => Contact::body(BodyKind::Object, object),
        Tag::Link { arm, .. } => Contact::body(BodyKind::Arm, arm),
        Tag::Fixture(fixture) => Contact::body(BodyKind::Fixture, fixture),
    }
}
