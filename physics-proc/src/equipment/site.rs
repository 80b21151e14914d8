//! The part of the world that equipment acts upon.

use cell_model::random::Random;
use nalgebra::{Isometry3, Vector3};
use rapier3d_f64::prelude::*;

use crate::arm::memory::{self, ArmMemory};
use crate::engine::convert;
use crate::engine::objects::Objects;
use crate::operator::drag::Drag;

/// The objects of the cell, the hands and cups that hold them, and the time.
pub(crate) struct Site<'w> {
    pub(crate) engine: &'w mut PhysicsWorld,
    pub(crate) objects: &'w Objects,
    pub(crate) drags: &'w mut Vec<Drag>,
    pub(crate) arms: &'w [ArmMemory],
    pub(crate) tick: u64,
}

/// Random numbers of the equipment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stream {
    /// Seed of the run.
    pub(crate) seed: u64,
}

impl Stream {
    /// A generator for item `index` of a device. The result depends only on the seed, the
    /// device and that number.
    pub(crate) fn random(self, device: u64, index: u64) -> Random {
        let mut devices = Random::new(self.seed.wrapping_add(device << 32));
        Random::new(devices.bits().wrapping_add(index))
    }
}

impl Site<'_> {
    /// Whether an object is in the cell.
    pub(crate) fn is_here(&self, object: usize) -> bool {
        self.objects.is_here(self.engine, object)
    }

    /// Whether a gripper has an object by suction.
    pub(crate) fn is_attached(&self, object: usize) -> bool {
        memory::is_attached(self.arms, object)
    }

    /// Puts a parked object into the cell.
    pub(crate) fn bring(
        &mut self,
        object: usize,
        pose: &Isometry3<f64>,
        linear: &Vector3<f64>,
        angular: &Vector3<f64>,
    ) {
        let Some(body) = self.objects.body_mut(self.engine, object) else {
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
        if let Some(body) = self.objects.body_mut(self.engine, object) {
            body.set_linvel(Vector::ZERO, true);
            body.set_angvel(Vector::ZERO, true);
            body.reset_forces(true);
            body.reset_torques(true);
            body.set_enabled(false);
        }
    }

    /// Moves an object to its parking place, at rest.
    pub(crate) fn rest_at_its_place(&mut self, object: usize) {
        let Some(spec) = self.objects.specs.get(object) else {
            return;
        };
        if let Some(body) = self.objects.body_mut(self.engine, object) {
            body.set_position(convert::to_pose(&spec.pose), true);
            body.set_linvel(Vector::ZERO, true);
            body.set_angvel(Vector::ZERO, true);
            body.reset_forces(true);
            body.reset_torques(true);
        }
    }
}
