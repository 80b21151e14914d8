//! What one decision works with.

use super::JOINTS;
use super::aim;
use super::geometry;
use super::memory::{Work, WorkKind};
use super::scene::{Bin, View};
use super::setup::PalletizeSetup;
use super::table::Facts;
use crate::failure::Failure;
use robocell_skills::KeptPose;
use robocell_skills::setup::ARM;
use robocell_task::job::{Attempts, Job};
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::time::PolicyTime;

/// What one tick works with.
pub(super) struct Tick<'a> {
    pub(super) setup: &'a PalletizeSetup,
    pub(super) scene: View<'a>,
    pub(super) observation: &'a Observation<'a>,
    pub(super) now: PolicyTime,
}

impl<'a> Tick<'a> {
    pub(super) fn new(setup: &'a PalletizeSetup, observation: &'a Observation<'a>) -> Option<Self> {
        Some(Self {
            setup,
            scene: View::read(setup, observation)?,
            observation,
            now: observation.time(),
        })
    }
}

impl Tick<'_> {
    pub(super) fn facts(&self, bin: Option<usize>) -> Facts {
        let seen = bin.and_then(|bin| self.scene.bin(bin));
        Facts {
            needs_flip: seen.is_some_and(|seen| geometry::opens_down(&seen.pose)),
            complete: self.scene.complete(),
        }
    }

    pub(super) fn joints(&self) -> [f64; JOINTS] {
        let arm = self.observation.arm(ARM);
        arm.map_or([0.0; JOINTS], |arm| aim::joints(&arm.joint_positions))
    }

    /// Where the bin on the cup goes, and the tool with it.
    pub(super) fn choose_place(&self, work: &mut Work) {
        work.slot = self.scene.free_slot();
        let (Some(slot), Some(bin)) = (
            work.slot.and_then(|slot| self.setup.slots.get(slot)),
            self.scene.bin(work.bin),
        ) else {
            return;
        };
        let grip = self.scene.tool.inverse() * bin.pose;
        let from = match work.kind {
            WorkKind::PlaceFromHome => &self.setup.home.rotation,
            _ => &self.scene.tool.rotation,
        };
        let target = geometry::place(slot, &grip, from);
        work.base = KeptPose::from(&target);
    }

    /// Counts a failure with a bin; how many of its kind in a row it is.
    pub(super) fn count_failure(&self, work: &Work, job: &mut Job) -> u32 {
        let object = self.setup.bins.get(work.bin).map(|spec| spec.object);
        let Some(attempts) = object.and_then(|object| job.attempts_mut(object)) else {
            return u32::MAX;
        };
        let picks = matches!(work.kind, WorkKind::Pick | WorkKind::PickFlipped);
        let count = if picks {
            &mut attempts.pick
        } else {
            &mut attempts.place
        };
        *count += 1;
        *count
    }

    /// The bin was lifted: what failed before it counts no more.
    pub(super) fn forgive_picks(&self, bin: usize, job: &mut Job) {
        let object = self.setup.bins.get(bin).map(|spec| spec.object);
        if let Some(attempts) = object.and_then(|object| job.attempts_mut(object)) {
            attempts.pick = 0;
        }
    }

    /// Whether the bin that was let go is in its place.
    pub(super) fn judge_place(&self, work: &Work, job: &mut Job, out: &mut Output) {
        let name = self.setup.name(work.bin);
        let seen = self.scene.bin(work.bin);
        let slot = seen.and_then(|seen| self.scene.slot_of(&seen));
        let object = self.setup.bins.get(work.bin).map(|spec| spec.object);
        let Some(attempts) = object.and_then(|object| job.attempts_mut(object)) else {
            return;
        };
        if let Some(slot) = slot {
            *attempts = Attempts::default();
            out.log(format_args!("[placed] {name} in place {}", slot + 1));
            return;
        }
        attempts.place += 1;
        let again = attempts.place < self.setup.numbers.max_attempts;
        out.log(format_args!("[missed] {name} is not in its place"));
        job.counters.recoveries += 1;
        if !again {
            job.fail(Failure::BinCannotBePlaced.reason());
        }
    }

    /// A bin waits at the end of the belt; pushed on against the stop it would
    /// jam, and be too near to the arm.
    pub(super) fn bin_waits(&self) -> bool {
        let end = self.setup.numbers.belt_stop_y_m;
        self.scene.present().any(|(bin, seen)| {
            Some(bin) != self.scene.attached
                && self.scene.on_belt(&seen)
                && seen.pose.translation.y < end
        })
    }

    /// The next bin is asked for when the last one has left the belt.
    pub(super) fn wants_bin(&self) -> bool {
        let on_cup = |bin: usize| Some(bin) == self.scene.attached;
        let waits = |(bin, seen): (usize, Bin)| {
            !on_cup(bin) && self.scene.slot_of(&seen).is_none() && self.scene.on_belt(&seen)
        };
        let present = self.scene.present().count();
        present < self.setup.wanted && !self.scene.present().any(waits)
    }
}
