//! Settings of the engine. Its defaults are made for game piles; with these a
//! grasp holds (measured: a 0.1 kg cube between two pads at 20 N slips less than
//! a thousandth of a millimetre in 10 s, and a tower stands still).

use rapier3d_f64::prelude::*;

/// Length of one tick (s).
pub const TICK_S: f64 = 1.0e-3;
/// Gravity in the world frame (m/s²).
pub const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];
/// Solver iterations; the engine runs each as a substep.
pub(crate) const SUBSTEPS: usize = 4;
/// Stiffness of contacts (Hz). Higher buzzes in towers, lower sinks in.
const CONTACT_HZ: f64 = 250.0;
/// Stiffness of contacts with fixed bodies (Hz).
const STATIC_CONTACT_HZ: f64 = 500.0;
/// Contacts are made from this distance on (m).
const PREDICTION_M: f64 = 0.002;
/// Contacts that moved less are not computed again (m).
const RECYCLE_M: f64 = 0.001;

/// An empty world with these settings.
pub(crate) fn empty_world() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::from(GRAVITY);
    let p = &mut world.integration_parameters;
    p.dt = TICK_S;
    p.num_solver_iterations = SUBSTEPS;
    p.num_internal_pgs_iterations = 1;
    p.num_internal_stabilization_iterations = 1;
    p.contact_softness = SpringCoefficients::new(CONTACT_HZ, 1.0);
    p.static_contact_softness = SpringCoefficients::new(STATIC_CONTACT_HZ, 1.0);
    p.friction_in_bias_pass = true;
    p.contact_recycling = true;
    p.normalized_contact_recycle_distance = RECYCLE_M;
    p.normalized_prediction_distance = PREDICTION_M;
    p.max_ccd_substeps = 0;
    p.contact_clustering = true;
    p.friction_model = FrictionModel::Simplified;
    p.warmstart_joints = false;
    world
}

/// With so many objects or fewer, contacts of theirs are computed again, too: it costs 2 us
/// with four cubes and saves a tower of four a drift of 2 um/s (measured).
pub(crate) const FEW_OBJECTS: usize = 16;

/// Marks a collider whose contacts go through [`crate::equipment::conveyor::Hooks`].
pub(crate) const FRESH: ActiveHooks = ActiveHooks::MODIFY_SOLVER_CONTACTS;

/// A time as ticks; negative ones are none.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a conversion that saturates"
)]
pub(crate) fn ticks(seconds: f64) -> u64 {
    (seconds / TICK_S).round() as u64
}
