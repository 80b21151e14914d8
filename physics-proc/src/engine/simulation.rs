//! The engine as a component of the world: the bodies, the objects among them, and its own
//! failures.

use std::panic::{AssertUnwindSafe, catch_unwind};

use cell_model::ObjectSpec;
use nalgebra::{Isometry3, Vector3};
use rapier3d_f64::prelude::*;
use serde::{Deserialize, Serialize};

use crate::engine::objects::Objects;
use crate::engine::settings::{PREDICTION_M, TICK_S};
use crate::engine::{convert, manifolds};

/// Contacts of an object that moves faster than this are made ahead by its way in a tick (m/s).
// Two objects that are slower do not pass the distance in which all contacts are made.
const FAST_M_S: f64 = 0.5 * PREDICTION_M / TICK_S;
/// The largest such way (m).
// Without it 6 of 40 washers of 1 mm that fall from 0.7 to 1.2 m pass a sheet of 1 mm. This
// covers 20 m/s; sweeps (`max_ccd_substeps`) stop fewer of them.
const FAST_WAY_M: f64 = 0.02;

/// The engine, and the objects of the cell by their index in the cell file.
pub(crate) struct Engine {
    rapier: PhysicsWorld,
    objects: Objects,
    /// Bodies the engine disabled since the start.
    quarantined: u32,
    /// The engine panicked and is not stepped any more.
    broken: bool,
    /// Bodies rest, and the joints of arms are where their setpoints are.
    ideal: bool,
}

/// The part of the engine in a snapshot.
#[derive(Deserialize)]
pub(crate) struct SavedEngine {
    quarantined: u32,
    broken: bool,
    rapier: PhysicsWorld,
}

impl Engine {
    /// An engine with all bodies of a cell.
    pub(crate) fn new(rapier: PhysicsWorld, objects: Objects) -> Self {
        Self {
            rapier,
            objects,
            quarantined: 0,
            broken: false,
            ideal: false,
        }
    }

    /// From now on bodies rest, and joints are where their setpoints are: for a model of the
    /// processes, which has no use for dynamics.
    pub(crate) fn make_ideal(&mut self) {
        self.ideal = true;
    }

    /// Whether bodies have no dynamics.
    pub(crate) fn is_ideal(&self) -> bool {
        self.ideal
    }

    /// Integrates one tick. The engine panics when a driven joint stops being finite: the scene
    /// then stays at rest until a reset, which replaces the engine.
    pub(crate) fn step(&mut self, hooks: &dyn PhysicsHooks) {
        // The engine may be in any state after a panic: it is not stepped again, only replaced.
        if self.broken || self.ideal {
            return;
        }
        self.predict_contacts();
        let rapier = &mut self.rapier;
        let step = AssertUnwindSafe(|| rapier.step_with_events(hooks, &()));
        self.broken = catch_unwind(step).is_err();
        self.quarantined += if self.broken {
            1
        } else {
            u32::try_from(self.disabled().len()).unwrap_or(0)
        };
    }

    /// Has the engine make contacts of fast objects ahead, or thin ones pass each other within a
    /// tick. Slow ones keep the margin of all contacts, which the engine then leaves out.
    fn predict_contacts(&mut self) {
        for object in 0..self.objects().len() {
            let Some(body) = self.object(object) else {
                continue;
            };
            let is_fast = body.linvel().length_squared() > FAST_M_S * FAST_M_S;
            // The engine examines every body that was borrowed to be changed.
            let changes = is_fast != (body.soft_ccd_prediction() > 0.0);
            if changes && let Some(body) = self.object_mut(object) {
                body.set_soft_ccd_prediction(if is_fast { FAST_WAY_M } else { 0.0 });
            }
        }
    }

    /// Bodies that the engine disabled in the last step.
    pub(crate) fn disabled(&self) -> &[RigidBodyHandle] {
        self.rapier.quarantine().bodies()
    }

    /// Number of bodies that the engine disabled since the start.
    pub(crate) fn quarantined(&self) -> u32 {
        self.quarantined
    }

    /// Whether the engine panicked: its numbers may not be finite.
    pub(crate) fn is_broken(&self) -> bool {
        self.broken
    }

    /// The engine of the library.
    pub(crate) fn rapier(&self) -> &PhysicsWorld {
        &self.rapier
    }

    /// The engine of the library, to change.
    pub(crate) fn rapier_mut(&mut self) -> &mut PhysicsWorld {
        &mut self.rapier
    }

    /// The state as part of a snapshot; [`SavedEngine`] reads it.
    pub(crate) fn save(&self) -> impl Serialize + '_ {
        (self.quarantined, self.broken, &self.rapier)
    }

    /// Continues from a snapshot.
    pub(crate) fn restore(&mut self, saved: SavedEngine) {
        (self.quarantined, self.broken) = (saved.quarantined, saved.broken);
        self.rapier = saved.rapier;
        // Not part of the bytes: without it a restored world would keep contact points of round
        // shapes, and differ from the one that was saved.
        manifolds::renew_round(&mut self.rapier);
    }

    /// Back to the bodies at the start; the number of disabled bodies continues.
    pub(crate) fn reset(&mut self, initial: SavedEngine) {
        let quarantined = self.quarantined;
        self.restore(initial);
        self.quarantined = quarantined;
    }
}

/// The objects of the cell.
impl Engine {
    /// Their bodies.
    pub(crate) fn objects(&self) -> &[RigidBodyHandle] {
        self.objects.bodies()
    }

    /// Their specifications in the cell file.
    pub(crate) fn specs(&self) -> &[ObjectSpec] {
        self.objects.specs()
    }

    /// The body of an object.
    pub(crate) fn object(&self, object: usize) -> Option<&RigidBody> {
        self.rapier.bodies.get(*self.objects().get(object)?)
    }

    /// The body of an object, to change. The engine examines each body that was borrowed for
    /// change.
    pub(crate) fn object_mut(&mut self, object: usize) -> Option<&mut RigidBody> {
        let body = *self.objects().get(object)?;
        self.rapier.bodies.get_mut(body)
    }

    /// Pose of an object in the world frame, if it exists and is finite.
    pub(crate) fn object_pose(&self, object: usize) -> Option<Isometry3<f64>> {
        convert::finite_pose(self.object(object)?.position())
    }

    /// Whether an object is in the cell.
    pub(crate) fn is_here(&self, object: usize) -> bool {
        self.object(object).is_some_and(RigidBody::is_enabled)
    }

    /// Wakes the sleeping ones among the objects that `wakes` selects.
    pub(crate) fn wake(&mut self, wakes: impl Fn(usize, &RigidBody) -> bool) {
        for object in 0..self.objects().len() {
            let body = self.object(object);
            let is_due = body.is_some_and(|body| body.is_sleeping() && wakes(object, body));
            // The engine examines every body that was borrowed to be changed.
            if is_due && let Some(body) = self.object_mut(object) {
                body.wake_up(true);
            }
        }
    }

    /// Wakes all objects.
    pub(crate) fn wake_all(&mut self) {
        for body in self.objects.bodies() {
            self.rapier.wake_up(*body, true);
        }
    }

    /// Puts a parked object into the cell.
    pub(crate) fn bring(
        &mut self,
        object: usize,
        pose: &Isometry3<f64>,
        linear: &Vector3<f64>,
        angular: &Vector3<f64>,
    ) {
        let Some(body) = self.object_mut(object) else {
            return;
        };
        body.set_enabled(true);
        body.set_position(convert::to_pose(pose), true);
        body.set_linvel(convert::to_vector(linear), true);
        body.set_angvel(convert::to_vector(angular), true);
        body.wake_up(true);
    }

    /// Takes an object out of the cell; it keeps its pose.
    pub(crate) fn take_out(&mut self, object: usize) {
        if let Some(body) = self.object_mut(object) {
            stop(body);
            body.set_enabled(false);
        }
    }

    /// Moves an object to its parking place, at rest.
    pub(crate) fn park(&mut self, object: usize) {
        let Some(place) = self.specs().get(object).map(|spec| spec.pose) else {
            return;
        };
        if let Some(body) = self.object_mut(object) {
            body.set_position(convert::to_pose(&place), true);
            stop(body);
        }
    }
}

fn stop(body: &mut RigidBody) {
    body.set_linvel(Vector::ZERO, true);
    body.set_angvel(Vector::ZERO, true);
    body.reset_forces(true);
    body.reset_torques(true);
}
