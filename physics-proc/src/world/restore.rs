//! Snapshots of the world, and its restoration from a snapshot or to the start.

use serde::{Deserialize, Serialize};

use super::World;
use crate::arm::arms::SavedArm;
use crate::arm::drive::DriveState;
use crate::arm::touch_count::TouchCount;
use crate::engine::simulation::SavedEngine;
use crate::equipment::devices::DeviceStates;
use crate::error::WorldError;
use crate::gripper::grippers::Gripper;
use crate::operator::drag::Drags;
use crate::operator::panel::Panel;
use crate::state::snapshot;

/// The parts of the components, in the order of the bytes; [`World::parts`] writes them.
#[derive(Deserialize)]
struct Saved {
    tick: u64,
    arms: Vec<(DriveState, Gripper, TouchCount, u32)>,
    drags: Drags,
    equipment: DeviceStates,
    panel: Panel,
    engine: SavedEngine,
}

impl Saved {
    /// The parts of the arms, and of their grippers.
    fn take_arms(&mut self) -> (Vec<SavedArm>, Vec<Gripper>) {
        let arms = std::mem::take(&mut self.arms).into_iter();
        let parts = arms.map(|(drive, gripper, touches, stop_action)| {
            let arm = SavedArm {
                drive,
                touches,
                stop_action,
            };
            (arm, gripper)
        });
        parts.unzip()
    }
}

impl World {
    /// The present state as bytes.
    pub fn snapshot(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.write_snapshot(&mut bytes);
        bytes
    }

    /// Appends the present state to `out`, as [`World::snapshot`] gives it.
    pub(crate) fn write_snapshot(&self, out: &mut Vec<u8>) {
        snapshot::encode(self.fingerprint, &self.parts(), out);
    }

    /// The parts of the components, in the order of the fields of [`Saved`].
    fn parts(&self) -> impl Serialize + '_ {
        let arms = self.arms.save().zip(self.grippers.save());
        let arms = arms.map(|((drive, touches, stop), gripper)| (drive, gripper, touches, stop));
        let (drags, panel) = self.operator.save();
        (
            self.tick,
            arms.collect::<Vec<_>>(),
            drags,
            self.equipment.save(),
            panel,
            self.engine.save(),
        )
    }

    /// Goes back to a snapshot of this cell, its tick included.
    ///
    /// # Errors
    /// [`WorldError::Snapshot`] for bytes of another cell, engine or program;
    /// the world is unchanged then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), WorldError> {
        // Decoded as a whole before anything is assigned: damaged bytes leave the world
        // unchanged.
        let mut saved: Saved = snapshot::decode(self.fingerprint, bytes)?;
        let (arms, grippers) = saved.take_arms();
        self.tick = saved.tick;
        self.engine.restore(saved.engine);
        self.arms.restore(arms);
        self.grippers.restore(grippers);
        self.equipment.restore(saved.equipment);
        self.operator.restore(saved.drags, saved.panel);
        self.measure();
        Ok(())
    }

    /// Puts the scene back to its start. The tick continues, so that time never runs backwards
    /// for any reader; requests and the counts by which a run is judged are kept.
    ///
    /// # Errors
    /// As [`World::restore`].
    pub fn reset(&mut self) -> Result<(), WorldError> {
        let mut initial: Saved = snapshot::decode(self.fingerprint, &self.initial)?;
        let (arms, grippers) = initial.take_arms();
        self.engine.reset(initial.engine);
        self.arms.reset(arms, self.tick);
        self.grippers.restore(grippers);
        self.equipment.reset(initial.equipment, self.tick);
        self.operator.reset();
        self.measure();
        Ok(())
    }

    /// Joints and contacts are not part of the bytes; they are measured again.
    pub(super) fn measure(&mut self) {
        self.inputs.clear();
        self.arms.measure(&self.engine);
        self.grippers.measure(&mut self.engine, &self.arms);
    }
}
