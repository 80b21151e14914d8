//! Objects that are not in the cell: bins and parts that have not come yet, and
//! what fell out. Their bodies are disabled, which costs nothing.

use nalgebra::{Isometry3, Vector3};
use rapier3d_f64::prelude::*;
use serde::{Deserialize, Serialize};

use crate::convert;
use crate::world::World;

/// Who is on the way out.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ParkingMemory {
    /// Moved to their parking places in the last tick, to be disabled in this.
    leaving: Vec<usize>,
    /// Counts objects put away.
    pub(crate) cleared: u32,
}

impl ParkingMemory {
    pub(crate) fn carry_over(&mut self, before: &Self) {
        self.cleared = before.cleared;
    }
}

impl World {
    /// Whether an object is in the cell.
    pub(crate) fn is_here(&self, object: usize) -> bool {
        let body = self.objects.get(object);
        body.and_then(|handle| self.engine.bodies.get(*handle))
            .is_some_and(RigidBody::is_enabled)
    }

    /// Whether a gripper has it by suction.
    pub(crate) fn is_attached(&self, object: usize) -> bool {
        let mut arms = self.memory.arms.iter();
        arms.any(|arm| arm.suction.attached() == Some(object))
    }

    /// Puts a parked object into the cell.
    pub(crate) fn bring(
        &mut self,
        object: usize,
        pose: &Isometry3<f64>,
        linear: &Vector3<f64>,
        angular: &Vector3<f64>,
    ) {
        let handle = self.objects.get(object);
        let Some(body) = handle.and_then(|handle| self.engine.bodies.get_mut(*handle)) else {
            return;
        };
        body.set_enabled(true);
        body.set_position(convert::to_pose(pose), true);
        body.set_linvel(convert::to_vector(linear), true);
        body.set_angvel(convert::to_vector(angular), true);
        body.wake_up(true);
    }

    /// Puts what fell out of the cell back to its place.
    pub(crate) fn clear_fallen(&mut self) {
        for object in std::mem::take(&mut self.memory.equipment.parking.leaving) {
            self.rest_at_its_place(object);
            let handle = self.objects.get(object);
            if let Some(body) = handle.and_then(|handle| self.engine.bodies.get_mut(*handle)) {
                body.set_enabled(false);
            }
        }
        let Some(floor) = self.equipment.clear_below else {
            return;
        };
        for object in 0..self.objects.len() {
            let handle = self.objects.get(object);
            let body = handle.and_then(|handle| self.engine.bodies.get(*handle));
            let fallen = body.is_some_and(|b| b.is_enabled() && b.translation().z < floor);
            if fallen && !self.is_attached(object) {
                self.park(object);
            }
        }
    }

    fn park(&mut self, object: usize) {
        self.rest_at_its_place(object);
        self.memory.drags.retain(|drag| drag.object != object);
        let parking = &mut self.memory.equipment.parking;
        parking.leaving.push(object);
        parking.cleared = parking.cleared.wrapping_add(1);
    }

    fn rest_at_its_place(&mut self, object: usize) {
        let (Some(handle), Some(spec)) =
            (self.objects.get(object), self.equipment.specs.get(object))
        else {
            return;
        };
        if let Some(body) = self.engine.bodies.get_mut(*handle) {
            body.set_position(convert::to_pose(&spec.pose), true);
            body.set_linvel(Vector::ZERO, true);
            body.set_angvel(Vector::ZERO, true);
            body.reset_forces(true);
            body.reset_torques(true);
        }
    }
}
