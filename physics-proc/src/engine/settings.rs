//! Settings of the engine. Its defaults are made for game piles; with these a
//! grasp holds (measured: a 0.1 kg cube between two pads at 20 N slips less than
//! a hundredth of a millimetre in 10 s) and a tower stays at rest.

use rapier3d_f64::prelude::*;

use crate::engine::manifolds;

pub use cell_model::robots::dynamics::GRAVITY;
pub use ipc_types::TICK_S;

/// Solver iterations; the engine runs each as a substep, with a mass matrix of its own. A
/// second one takes 1.5 times as long and holds no better than more iterations within one.
pub(crate) const SUBSTEPS: usize = 1;
/// Iterations over all joints and contacts within a substep, and as many more that take no
/// depth of contacts into account.
// The fingers of a hand are coupled by a row, and each iteration corrects about finger mass /
// load of the error between it and the contacts: with one of the second kind a load of 1.6 kg
// trembles between two fingers of 0.1 kg and creeps by 0.7 mm/s. With two of the first kind a
// held cube sinks in by 0.10 mm, with three by 0.07; with four an upright cylinder at its
// friction limit on a slope creeps (ADR 41).
const ITERATIONS: usize = 3;
/// Stiffness of contacts (Hz).
// At 150 a grasp of 20 N sinks in by 0.18 mm, at 250 by 0.10 (with four substeps); from 1000
// on towers and bins buzz.
const CONTACT_HZ: f64 = 250.0;
/// Stiffness of contacts with fixed bodies (Hz).
// Twice that of two moving bodies, since a fixture does not give way.
const STATIC_CONTACT_HZ: f64 = 500.0;
/// Contacts are made from this distance on (m).
// The length of a fast approach in one tick (2 m/s); `Engine::step` adds to it for faster ones.
// The default of the engine is 20 mm, for game piles.
pub(crate) const PREDICTION_M: f64 = 0.002;

/// Unit of lengths of the engine (m), a power of two. Its broad phase keeps a pair of shapes
/// within 0.08 units of each other: at 1 m, its default, these are most pairs of a pile of
/// small parts.
// A power of two scales without rounding, so the unit changes no result by itself.
pub(crate) const LENGTH_UNIT_M: f64 = 0.125;

/// An empty world with these settings.
pub(crate) fn empty_world() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::from(GRAVITY);
    let p = &mut world.integration_parameters;
    p.dt = TICK_S;
    p.num_solver_iterations = SUBSTEPS;
    p.num_internal_pgs_iterations = ITERATIONS;
    p.num_internal_stabilization_iterations = ITERATIONS;
    p.contact_softness = SpringCoefficients::new(CONTACT_HZ, 1.0);
    p.static_contact_softness = SpringCoefficients::new(STATIC_CONTACT_HZ, 1.0);
    // Friction against a velocity that corrects depth turns a held object, by 5 mm in 10 s.
    // Without it an object held by friction moves by its change of acceleration times the square
    // of a tick, 10 um at 10 m/s^2, and back with it.
    p.friction_in_bias_pass = false;
    // Recycled contact points let a grasp slip and a tower of ten sway until it falls.
    p.contact_recycling = false;
    p.length_unit = LENGTH_UNIT_M;
    p.normalized_prediction_distance = PREDICTION_M / LENGTH_UNIT_M;
    // These keep the values that they have with a unit of 1 m.
    p.normalized_allowed_linear_error /= LENGTH_UNIT_M;
    p.normalized_max_corrective_velocity /= LENGTH_UNIT_M;
    p.normalized_max_linear_velocity /= LENGTH_UNIT_M;
    // Sweeps for fast bodies changed nothing: no part went through a wall of 4 mm without
    // them.
    p.max_ccd_substeps = 0;
    p.contact_clustering = true;
    // The simplified model forgets the velocity of a belt after the first substep: a belt of
    // 0.2 m/s then moves a box at 0.193 m/s (ADR 0029).
    p.friction_model = FrictionModel::Coulomb;
    p.warmstart_joints = false;
    // Points of round shapes are not kept between ticks (ADR 0028).
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
