//! Contact points of round shapes are computed in every tick.
//!
//! The collision library keeps the points of a pair until the bodies have turned by a degree
//! or slid by a millimetre against each other. A kept point of a rolling cylinder stays behind
//! its centre: the normal force then has a lever arm and drives the cylinder, by one degree a
//! tick on a level floor. Balls have no kept points, and faces of boxes do not roll. ADR 0028
//! has the cost, and the reasons why points are dropped and keep the impulses of the nearest one.

use parry3d_f64::math::{Pose, Real, Vector};
use parry3d_f64::query::details::{ContactManifoldsWorkspace, NormalConstraints, ShapeCastOptions};
use parry3d_f64::query::{
    ClosestPoints, Contact, ContactManifold, DefaultQueryDispatcher, NonlinearRigidMotion,
    PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit, ShapeDistance, ShapeIntersection,
    TrackedContact, Unsupported,
};
use parry3d_f64::shape::{PackedFeatureId, Shape, ShapeType};
use rapier3d_f64::prelude::{ContactData, ContactManifoldData, PhysicsWorld};

type Manifold = ContactManifold<ContactManifoldData, ContactData>;
type Point = TrackedContact<ContactData>;

/// Points are as near as another one within this (m).
// Two equal distances differ by rounding; 0.1 um is far below the depth of any contact.
const AS_NEAR_M: Real = 1.0e-7;

/// Has the engine compute the contact points of round shapes in every tick. This is not part of
/// a snapshot: an engine that was read from one needs it again.
pub(crate) fn renew_round(engine: &mut PhysicsWorld) {
    let dispatcher = RenewRound.chain(DefaultQueryDispatcher);
    engine.narrow_phase.set_query_dispatcher(dispatcher);
}

/// Answers for contact manifolds only; the library's dispatcher after it answers all else.
struct RenewRound;

fn is_round(shape: &dyn Shape) -> bool {
    matches!(
        shape.shape_type(),
        ShapeType::Capsule | ShapeType::Cylinder | ShapeType::Cone
    )
}

/// Drops the nearest point of both shapes, which the library adds to the points of their edges
/// and faces, if one of these is as near. Along a line or a face any point is the nearest: it
/// is another one in each tick, and its impulse makes a held rod creep, by 20 um/s (ADR 0028).
fn drop_wandering(manifold: &mut Manifold) {
    let is_nearest = |point: &Point| point.fid1 == PackedFeatureId::UNKNOWN;
    let of_features = manifold.points.iter().filter(|point| !is_nearest(point));
    let least = of_features.fold(Real::INFINITY, |least, point| least.min(point.dist));
    (manifold.points).retain(|point| !is_nearest(point) || point.dist + AS_NEAR_M < least);
}

/// Drops repeated points: the library clips a line against a face once for each of its two ends.
/// With them a rod in a hand swings until it falls (ADR 28).
fn drop_repeated(manifold: &mut Manifold) {
    let ids = |point: &Point| (point.fid1, point.fid2);
    let mut seen = Vec::with_capacity(manifold.points.len());
    manifold.points.retain(|point| {
        let is_new = !seen.contains(&ids(point));
        seen.push(ids(point));
        is_new
    });
}

/// Gives each point the impulses of the nearest one before, each once. The library goes by the
/// numbers of edges and corners, but the square that stands for the face of a cylinder turns with
/// the smallest tilt, and its numbers with it: a cylinder at rest creeps by 1 mm/s then.
fn keep_impulses(before: &mut Vec<Point>, manifold: &mut Manifold) {
    for point in &mut manifold.points {
        let far = |old: &Point| (old.local_p1 - point.local_p1).length_squared();
        let old = (0..before.len()).min_by(|a, b| far(&before[*a]).total_cmp(&far(&before[*b])));
        point.data = old.map_or_else(ContactData::default, |at| before.swap_remove(at).data);
    }
}

impl PersistentQueryDispatcher<ContactManifoldData, ContactData> for RenewRound {
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<Manifold>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        // Boxes keep their points: faces do not roll, and computing all of them takes a pile
        // of boxes 1.2 to 1.6 times as long (ADR 0028).
        let mut before: Vec<Vec<Point>> = Vec::new();
        if is_round(shape1) || is_round(shape2) {
            before.extend(manifolds.iter().map(|of| of.points.clone()));
            // The library then computes the points of a manifold again and keeps the impulses.
            manifolds
                .iter_mut()
                .for_each(Manifold::mark_shapes_deformed);
        }
        DefaultQueryDispatcher
            .contact_manifolds(pos12, shape1, shape2, prediction, manifolds, workspace)?;
        if is_round(shape1) || is_round(shape2) {
            manifolds.iter_mut().for_each(drop_wandering);
            manifolds.iter_mut().for_each(drop_repeated);
            if before.len() == manifolds.len() {
                for (before, manifold) in before.iter_mut().zip(manifolds.iter_mut()) {
                    keep_impulses(before, manifold);
                }
            }
        }
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
        _: Option<&dyn NormalConstraints>,
        _: Option<&dyn NormalConstraints>,
        _: Real,
        _: &mut Manifold,
    ) -> Result<(), Unsupported> {
        // `Unsupported` hands a query to the next dispatcher of the chain.
        Err(Unsupported)
    }
}

impl QueryDispatcher for RenewRound {
    fn intersection_test(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        Err(Unsupported)
    }

    fn distance(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
    ) -> Result<ShapeDistance, Unsupported> {
        Err(Unsupported)
    }

    fn contact(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
        _: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        Err(Unsupported)
    }

    fn closest_points(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
        _: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        Err(Unsupported)
    }

    fn cast_shapes(
        &self,
        _: &Pose,
        _: Vector,
        _: &dyn Shape,
        _: &dyn Shape,
        _: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        Err(Unsupported)
    }

    fn cast_shapes_nonlinear(
        &self,
        _: &NonlinearRigidMotion,
        _: &dyn Shape,
        _: &NonlinearRigidMotion,
        _: &dyn Shape,
        _: Real,
        _: Real,
        _: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        Err(Unsupported)
    }
}
