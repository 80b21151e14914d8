//! The operator's hand: a spring that pulls one object, never a teleport.
//!
//! The hand walks from the object to the place asked for and slows down before
//! it; the object follows on a critically damped spring of bounded force that
//! carries the object's weight. The orientation is kept by a soft spring.

use nalgebra::{Isometry3, Vector3};
use rapier3d_f64::prelude::*;
use serde::{Deserialize, Serialize};

use crate::engine::convert;
use crate::engine::settings::{GRAVITY, TICK_S};
use crate::engine::simulation::Engine;

/// Largest force of the spring (N).
// Carries 8 kg; a cube in the hand slips by 0.2 mm under this force (ADR 0030).
pub const MAX_FORCE_N: f64 = 80.0;
/// Nearer than this the object has arrived (m).
// The hand moves at 40 mm/s there, so the object is released slowly.
pub const ARRIVED_M: f64 = 0.005;
/// Duration of a request without one (s).
pub const DEFAULT_SECONDS: f64 = 2.0;
/// Largest speed of the hand (m/s).
// The object then follows 17 mm behind the hand: 2 v / omega of the spring.
const SPEED_M_S: f64 = 0.5;
/// The hand approaches the place with this rate (1/s).
// From its largest speed the hand slows down over the last 62 mm.
const APPROACH_PER_S: f64 = 8.0;
/// Frequency of the spring (rad/s): a 0.1 kg cube is pulled with 36 N over 10 cm.
const SPRING_RAD_S: f64 = 60.0;
/// Frequency of the spring about the axes (rad/s).
// A third of the linear one: an object may be turned by the shapes that it touches.
const TURN_RAD_S: f64 = 20.0;
/// Largest torque (N·m).
const MAX_TORQUE_NM: f64 = 1.0;

/// One drag under way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Drag {
    /// Object by its place in the cell.
    object: usize,
    /// The hand (m, world).
    hand: [f64; 3],
    /// Goal of the object (m, world).
    target: [f64; 3],
    /// Orientation to keep, x y z w.
    orientation: [f64; 4],
    ticks_left: u64,
}

/// All drags under way: part of every snapshot.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Drags(Vec<Drag>);

impl Drags {
    /// Drags the object at `pose` to `target` (m, world) for at most `seconds`.
    pub(super) fn start(
        &mut self,
        object: usize,
        pose: &Isometry3<f64>,
        target: [f64; 3],
        seconds: f64,
    ) {
        // A new drag replaces the one of the same object; two springs on it would fight each
        // other.
        self.end(object);
        self.0.push(Drag::new(object, pose, target, seconds));
        // In the order of objects, not of requests: equal runs have equal snapshots.
        self.0.sort_by_key(|drag| drag.object);
    }

    /// Ends the drag of an object.
    pub(crate) fn end(&mut self, object: usize) {
        self.0.retain(|drag| drag.object != object);
    }

    /// Whether an object is dragged.
    pub(super) fn contains(&self, object: usize) -> bool {
        self.0.iter().any(|drag| drag.object == object)
    }

    /// Pulls every object that is dragged; drags that have ended are removed.
    pub(super) fn pull(&mut self, engine: &mut Engine) {
        self.0.retain_mut(|drag| {
            let body = engine.object_mut(drag.object);
            body.is_some_and(|body| drag.apply(body))
        });
    }
}

impl Drag {
    /// Takes hold of an object at `pose`.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "seconds are validated to 0..3600"
    )]
    fn new(object: usize, pose: &Isometry3<f64>, target: [f64; 3], seconds: f64) -> Self {
        let seconds = if seconds > 0.0 {
            seconds
        } else {
            DEFAULT_SECONDS
        };
        Self {
            object,
            hand: pose.translation.vector.into(),
            target,
            orientation: pose.rotation.coords.into(),
            ticks_left: (seconds / TICK_S).round() as u64,
        }
    }

    /// Sets the forces of one tick; false when the drag is over.
    fn apply(&mut self, body: &mut RigidBody) -> bool {
        // Forces of the last tick would add up: the engine keeps them until they are reset.
        body.reset_forces(true);
        body.reset_torques(true);
        let position = convert::from_vector(body.translation());
        let target = Vector3::from(self.target);
        if self.ticks_left == 0 || (target - position).norm() <= ARRIVED_M {
            return false;
        }
        self.ticks_left -= 1;
        self.move_hand(target);
        let force = self.force(body, &position);
        body.add_force(convert::to_vector(&force), true);
        body.add_torque(convert::to_vector(&self.torque(body)), true);
        true
    }

    fn move_hand(&mut self, target: Vector3<f64>) {
        let hand = Vector3::from(self.hand);
        let path = target - hand;
        let speed = (APPROACH_PER_S * path.norm()).min(SPEED_M_S);
        let next = if path.norm() > speed * TICK_S {
            hand + path.normalize() * speed * TICK_S
        } else {
            target
        };
        self.hand = next.into();
    }

    fn force(&self, body: &RigidBody, position: &Vector3<f64>) -> Vector3<f64> {
        let velocity = convert::from_vector(body.linvel());
        let stretch = Vector3::from(self.hand) - position;
        let acceleration = stretch * (SPRING_RAD_S * SPRING_RAD_S)
            - velocity * (2.0 * SPRING_RAD_S)
            - Vector3::from(GRAVITY);
        bounded(acceleration * body.mass(), MAX_FORCE_N)
    }

    fn torque(&self, body: &RigidBody) -> Vector3<f64> {
        let [x, y, z, w] = self.orientation;
        let wanted = Rotation::from_xyzw(x, y, z, w);
        let mut turn = wanted * body.rotation().inverse();
        if turn.w < 0.0 {
            // The shorter of the two turns; the other one would spin the object around.
            turn = -turn;
        }
        // For the soft spring the sine of the half angle is close enough.
        let angle = Vector3::new(turn.x, turn.y, turn.z) * 2.0;
        let spin = convert::from_vector(body.angvel());
        let inertia = body.mass_properties().local_mprops.principal_inertia();
        let scale = (inertia.x + inertia.y + inertia.z) / 3.0;
        bounded(
            (angle * (TURN_RAD_S * TURN_RAD_S) - spin * (2.0 * TURN_RAD_S)) * scale,
            MAX_TORQUE_NM,
        )
    }
}

fn bounded(vector: Vector3<f64>, limit: f64) -> Vector3<f64> {
    let norm = vector.norm();
    if norm > limit {
        vector * (limit / norm)
    } else {
        vector
    }
}
