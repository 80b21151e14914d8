//! Settings of the engine. Its defaults are made for game piles; with these a
//! grasp holds (measured: a 0.1 kg cube between two pads at 20 N slips less than
//! a hundredth of a millimetre in 10 s) and a tower stays at rest.

use rapier3d_f64::prelude::*;

use crate::engine::manifolds;

/// Length of one tick (s).
pub const TICK_S: f64 = 1.0e-3;
/// Gravity in the world frame (m/s²).
pub const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];
/// Solver iterations; the engine runs each as a substep. Four take 1.5 times as long; with one
/// a tower of four boxes does not stay at rest.
pub(crate) const SUBSTEPS: usize = 2;
/// Stiffness of contacts (Hz). Higher buzzes in towers, lower sinks in.
const CONTACT_HZ: f64 = 250.0;
/// Stiffness of contacts with fixed bodies (Hz).
const STATIC_CONTACT_HZ: f64 = 500.0;
/// Contacts are made from this distance on (m).
const PREDICTION_M: f64 = 0.002;

/// Unit of lengths of the engine (m), a power of two. Its broad phase keeps a pair of shapes
/// within 0.08 units of each other: at 1 m, which is its default, most pairs of a pile of small
/// parts are such.
pub(crate) const LENGTH_UNIT_M: f64 = 0.125;

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
    // Kept contact points let a grasp slip and a tower of ten sway until it falls (measured).
    p.contact_recycling = false;
    p.length_unit = LENGTH_UNIT_M;
    p.normalized_prediction_distance = PREDICTION_M / LENGTH_UNIT_M;
    // As with the unit of 1 m.
    p.normalized_allowed_linear_error /= LENGTH_UNIT_M;
    p.normalized_max_corrective_velocity /= LENGTH_UNIT_M;
    p.normalized_max_linear_velocity /= LENGTH_UNIT_M;
    p.max_ccd_substeps = 0;
    p.contact_clustering = true;
    // The simplified model forgets the velocity of a belt after the first substep
    // (docs/adr/0029).
    p.friction_model = FrictionModel::Coulomb;
    p.warmstart_joints = false;
    manifolds::renew_round(&mut world);
    world
}

/// A time as ticks; negative ones are none.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a conversion that saturates"
)]
pub(crate) fn ticks(seconds: f64) -> u64 {
    (seconds / TICK_S).round() as u64
}
