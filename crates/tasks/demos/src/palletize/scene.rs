//! The cell as the policy sees it in one decision.

use ipc_types::MAX_JOINTS;
use ipc_types::world::OBJECT_ENABLED;
use nalgebra::{Isometry3, Translation3, Vector2, Vector3};
use robocell_skills::pose;
use robocell_skills::setup::ARM;
use robocell_task::{Observation, PolicyTime};

use super::geometry::{self, Lie, is_level, lie};
use super::memory::Work;
use super::setup::PalletizeSetup;
use super::table::Facts;

/// A bin slower than this is at rest (m/s).
const AT_REST_M_S: f64 = 0.05;
/// A bin that is set down must not touch another one this far above its place, either (bin heights).
const WAY_DOWN: [f64; 3] = [0.0, 1.0, 2.0];

/// An observed bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bin {
    /// Its pose, world frame.
    pub(super) pose: Isometry3<f64>,
    /// Its speed (m/s).
    speed: f64,
}

/// The observation of one decision.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    pub(super) setup: &'a PalletizeSetup,
    pub(super) observation: &'a Observation<'a>,
    pub(super) now: PolicyTime,
    /// Measured pose of the tool, world frame.
    pub(super) tool: Isometry3<f64>,
    /// Measured joint positions (rad).
    pub(super) joints: [f64; MAX_JOINTS],
    /// The bin on the cup, by its index in the setup.
    pub(super) attached: Option<usize>,
    /// Whether anything is on the cup.
    pub(super) cup_taken: bool,
    /// Number of times that suction attached nothing.
    pub(super) refusals: u32,
}

impl<'a> View<'a> {
    /// The observation; `None` without an arm.
    pub(super) fn read(
        setup: &'a PalletizeSetup,
        observation: &'a Observation<'a>,
    ) -> Option<Self> {
        let arm = observation.arm(ARM)?;
        let cup_taken = arm.gripper.attached == 1;
        let held = observation.held_object(ARM).filter(|_| cup_taken);
        Some(Self {
            setup,
            observation,
            now: observation.time(),
            tool: pose::isometry(&arm.tcp),
            joints: arm.joint_positions,
            attached: held.and_then(|held| setup.bins.iter().position(|bin| bin.object == held)),
            cup_taken,
            refusals: arm.gripper.refusals,
        })
    }

    /// A bin, if it is in the cell.
    pub(super) fn bin(&self, bin: usize) -> Option<Bin> {
        let spec = self.setup.bins.get(bin)?;
        let state = self.observation.object(spec.object)?;
        (state.flags & OBJECT_ENABLED != 0).then(|| Bin {
            pose: pose::isometry(&state.pose),
            speed: Vector3::from(state.twist.linear).norm(),
        })
    }

    /// All bins in the cell.
    fn present(&self) -> impl Iterator<Item = (usize, Bin)> + '_ {
        let all = 0..self.setup.bins.len();
        all.filter_map(|bin| Some((bin, self.bin(bin)?)))
    }

    /// All bins that are not on the cup.
    fn free(&self) -> impl Iterator<Item = (usize, Bin)> + '_ {
        self.present()
            .filter(|(bin, _)| Some(*bin) != self.attached)
    }

    /// All bins in their places, with the index of the place.
    pub(super) fn placed(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.free()
            .filter_map(|(bin, seen)| Some((bin, self.slot_of(&seen)?)))
    }

    /// The index of the place that a bin is in.
    pub(super) fn slot_of(&self, bin: &Bin) -> Option<usize> {
        let tolerance = self.setup.task.slot_tolerance_m;
        // A bin that moves, leans or is upside down is not placed, even over its place.
        if bin.speed > AT_REST_M_S || !is_level(&bin.pose) {
            return None;
        }
        let mut slots = self.setup.slots.iter();
        slots.position(|slot| {
            let off = bin.pose.translation.vector - slot.translation.vector;
            off.xy().norm() < tolerance && off.z.abs() < tolerance
        })
    }

    /// The place for `bin`: the first free one.
    ///
    /// # Errors
    /// No place is free: the first one without a bin in it, and the bin in its way.
    pub(super) fn free_slot(&self, bin: usize) -> Result<usize, Option<(usize, usize)>> {
        let mut blocked = None;
        for slot in 0..self.setup.slots.len() {
            if self.placed().any(|(_, taken)| taken == slot) {
                continue;
            }
            match self.blocker(bin, slot) {
                None => return Ok(slot),
                Some(other) => blocked = blocked.or(Some((slot, other))),
            }
        }
        Err(blocked)
    }

    /// A bin outside of all places that `bin` would touch in a place, or on its way down.
    pub(super) fn blocker(&self, bin: usize, slot: usize) -> Option<usize> {
        let (spec, slot) = (self.setup.bins.get(bin)?, self.setup.slots.get(slot)?);
        let loose = || {
            let loose = self.free().filter(|(_, seen)| self.slot_of(seen).is_none());
            loose.filter_map(|(bin, _)| Some(self.setup.bins.get(bin)?.object))
        };
        let object = WAY_DOWN.into_iter().find_map(|heights| {
            let up = Translation3::new(0.0, 0.0, heights * spec.shape.size.z);
            let solids = &self.setup.solids;
            solids.blocker(self.observation, (spec.object, &(up * slot)), loose())
        })?;
        self.setup.bins.iter().position(|bin| bin.object == object)
    }

    /// The offset from the bin of `work` to its place (m).
    pub(super) fn off_place(&self, work: &Work) -> Option<Vector3<f64>> {
        let slot = self.setup.slots.get(work.slot?)?;
        let bin = self.bin(work.bin)?;
        Some(slot.translation.vector - bin.pose.translation.vector)
    }

    /// The facts that guards of the table read, about `bin`.
    pub(super) fn facts(&self, bin: Option<usize>) -> Facts {
        let seen = bin.and_then(|bin| self.bin(bin));
        Facts {
            needs_flip: seen.is_some_and(|seen| geometry::opens_down(&seen.pose)),
            complete: self.placed().count() >= self.setup.wanted,
        }
    }

    /// Whether a bin is in the jig.
    fn in_jig(&self, bin: &Bin) -> bool {
        let jig = &self.setup.task.jig;
        let off = bin.pose.translation.vector.xy() - Vector2::from(jig.middle_m);
        off.norm() < jig.radius_m
    }

    /// Whether a bin is on the belt, its start included.
    pub(super) fn on_belt(&self, bin: &Bin) -> bool {
        let task = &self.setup.task;
        within(bin.pose.translation.x, task.belt_x_m)
            && bin.pose.translation.y > task.belt_y_m[0]
            && !self.in_jig(bin)
    }

    /// The bin to pick next: one in the jig, then one outside of its place, then the first at
    /// the end of the belt. One that is tilted cannot be gripped.
    pub(super) fn next_bin(&self) -> Option<usize> {
        let loose = || {
            self.present()
                .filter(|(_, bin)| self.slot_of(bin).is_none())
        };
        // The jig first: it has room for one bin, and the next one to be turned needs it.
        let jig = loose().find(|(_, bin)| self.in_jig(bin));
        let stray = || {
            loose()
                .filter(|(_, bin)| !self.on_belt(bin) && !self.in_jig(bin))
                .find(|(_, bin)| bin.speed < AT_REST_M_S && lie(&bin.pose) != Lie::Tilted)
        };
        let belt = || {
            let [_, end] = self.setup.task.belt_y_m;
            let waiting =
                loose().filter(|(_, bin)| self.on_belt(bin) && bin.pose.translation.y < end);
            waiting.min_by(|(_, a), (_, b)| a.pose.translation.y.total_cmp(&b.pose.translation.y))
        };
        jig.or_else(stray).or_else(belt).map(|(bin, _)| bin)
    }

    /// A bin that is not in its place while no other is to come; first one that leans.
    pub(super) fn left_over(&self) -> Option<usize> {
        let loose = || {
            self.present()
                .filter(|(_, bin)| self.slot_of(bin).is_none())
        };
        let all_came = self.present().count() >= self.setup.wanted;
        let leaning = loose().find(|(_, bin)| lie(&bin.pose) == Lie::Tilted);
        let left = leaning.or_else(|| loose().next()).filter(|_| all_came);
        left.map(|(bin, _)| bin)
    }

    /// Whether a bin waits at the end of the belt. Pushed on against the stop it would jam, and
    /// be too near to the arm.
    pub(super) fn bin_waits(&self) -> bool {
        let end = self.setup.task.belt_stop_y_m;
        let mut free = self.free();
        free.any(|(_, bin)| self.on_belt(&bin) && bin.pose.translation.y < end)
    }

    /// Whether to request the next bin: the last one has left the belt.
    pub(super) fn wants_bin(&self) -> bool {
        let mut free = self.free();
        let waits = free.any(|(_, bin)| self.slot_of(&bin).is_none() && self.on_belt(&bin));
        self.present().count() < self.setup.wanted && !waits
    }
}

fn within(value: f64, [low, high]: [f64; 2]) -> bool {
    value > low && value < high
}
