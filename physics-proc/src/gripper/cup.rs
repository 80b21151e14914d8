//! Finds the object at a suction cup: rays from its centre and its rim.

use cell_model::SuctionGripper;
use ipc_types::equipment::SuctionRefusal;
use nalgebra::{Isometry3, Vector3};
use parry3d_f64::query::{Ray, RayIntersection};
use rapier3d_f64::prelude::*;

use crate::engine::convert;
use crate::engine::tag::Tag;

/// Rays start this far inside the cup: a contact gives way a little, and a ray that starts
/// beyond the surface would miss it (m).
const INSIDE_M: f64 = 0.005;
/// Cosine of the largest angle between the cup's axis and the surface: 15
/// degrees is what a soft cup follows.
const LEAST_COSINE: f64 = 0.965_925_826_289_068_3;
/// Tangent of that angle: the additional distance of the rim from the surface, per radius.
const OBLIQUE_TANGENT: f64 = 0.267_949_192_431_122_7;
/// Largest distance of a hit of the rim from the plane of the surface at the centre (m).
const PLANE_M: f64 = 1.0e-3;
/// Share of the cup's radius at which its lip seals: a face as large as the cup is large enough.
const LIP_SHARE: f64 = 0.9;
/// Directions of the rim's rays in the plane of the cup.
const RIM: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];

/// The object that a cup at `tcp` (world frame) of arm `arm` would hold.
///
/// # Errors
/// The reason if it would hold nothing.
pub(crate) fn find(
    engine: &PhysicsWorld,
    arm: usize,
    tcp: &Isometry3<f64>,
    suction: &SuctionGripper,
) -> Result<usize, SuctionRefusal> {
    let axis = tcp.rotation * suction.axis;
    let centre = tcp.translation.vector;
    let (tag, hit) = nearest(engine, arm, &centre, &axis, suction.grip_distance)
        .ok_or(SuctionRefusal::NothingThere)?;
    let Tag::Object(object) = tag else {
        return Err(SuctionRefusal::NotMovable);
    };
    let normal = convert::from_vector(hit.normal);
    // Written so that a normal that is not a number is refused.
    if !(-normal.dot(&axis) >= LEAST_COSINE) {
        return Err(SuctionRefusal::TooOblique);
    }
    let distance = hit.time_of_impact - INSIDE_M;
    let surface = centre + axis * distance;
    let reach = suction.grip_distance + suction.cup_radius * OBLIQUE_TANGENT;
    let (side, up) = across(&axis);
    // The rim has to meet the same object in one plane: a cup on an edge or a step does not
    // seal.
    let seals = RIM.iter().all(|[a, b]| {
        let start = centre + (side * *a + up * *b) * (LIP_SHARE * suction.cup_radius);
        nearest(engine, arm, &start, &axis, reach).is_some_and(|(rim_tag, rim)| {
            let point = start + axis * (rim.time_of_impact - INSIDE_M);
            rim_tag == tag && (point - surface).dot(&normal).abs() <= PLANE_M
        })
    });
    if seals {
        Ok(object)
    } else {
        Err(SuctionRefusal::TooOblique)
    }
}

/// Two directions across the axis.
fn across(axis: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let other = if axis.x.abs() < 0.7 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let side = axis.cross(&other);
    let side = side / side.norm();
    (side, axis.cross(&side))
}

/// The first hit of a ray within `reach` of `start`; the arm itself is transparent.
fn nearest(
    engine: &PhysicsWorld,
    arm: usize,
    start: &Vector3<f64>,
    axis: &Vector3<f64>,
    reach: f64,
) -> Option<(Tag, RayIntersection)> {
    let ray = Ray::new(
        convert::to_vector(&(start - axis * INSIDE_M)),
        convert::to_vector(axis),
    );
    let hits = engine.colliders.iter().filter_map(|(_, collider)| {
        let tag = Tag::decode(collider.user_data);
        let own = matches!(tag, Tag::Link { arm: other, .. } if other == arm);
        let body = engine.bodies.get(collider.parent()?)?;
        // The tube of the cup surrounds the start of the ray; disabled bodies keep their
        // colliders.
        if own || !body.is_enabled() {
            return None;
        }
        let shape = collider.shape();
        let hit =
            shape.cast_ray_and_get_normal(collider.position(), &ray, reach + INSIDE_M, true)?;
        Some((tag, hit))
    });
    hits.min_by(|a, b| a.1.time_of_impact.total_cmp(&b.1.time_of_impact))
}
