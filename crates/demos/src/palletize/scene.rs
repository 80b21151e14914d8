//! What the policy sees of the cell.

use ipc_types::world::OBJECT_ENABLED;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{Lie, lie};
use super::setup::PalletizeSetup;
use robocell_skills::pose;
use robocell_skills::setup::ARM;
use robocell_task::observation::Observation;

/// A bin slower than this lies still (m/s).
const STILL_M_S: f64 = 0.05;
/// A place on the pallet is taken by what stands this near to it, be it in it
/// or beside it: nearer than to the next place (m).
const BESIDE_M: f64 = 0.15;

/// A bin as seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bin {
    /// Where it is.
    pub(super) pose: Isometry3<f64>,
    /// How fast (m/s).
    pub(super) speed: f64,
}

/// One sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    setup: &'a PalletizeSetup,
    observation: &'a Observation<'a>,
    /// The tool as measured.
    pub(super) tool: Isometry3<f64>,
    /// The bin on the cup, by its place in the setup.
    pub(super) attached: Option<usize>,
    /// Anything is on the cup.
    pub(super) cup_taken: bool,
    /// Counts switchings-on of suction that attached nothing.
    pub(super) refusals: u32,
}

impl<'a> View<'a> {
    /// The sample; `None` without an arm.
    pub(super) fn read(
        setup: &'a PalletizeSetup,
        observation: &'a Observation<'a>,
    ) -> Option<Self> {
        let arm = observation.arm(ARM)?;
        let held = observation.held_object(ARM);
        let cup_taken = arm.gripper.attached == 1;
        Some(Self {
            setup,
            observation,
            tool: pose::isometry(&arm.tcp),
            attached: held
                .filter(|_| cup_taken)
                .and_then(|object| setup.bins.iter().position(|bin| bin.object == object)),
            cup_taken,
            refusals: arm.gripper.refusals,
        })
    }

    /// A bin that is in the cell.
    pub(super) fn bin(&self, bin: usize) -> Option<Bin> {
        let spec = self.setup.bins.get(bin)?;
        let state = self.observation.object(spec.object)?;
        (state.flags & OBJECT_ENABLED != 0).then(|| Bin {
            pose: pose::isometry(&state.pose),
            speed: Vector3::from(state.twist.linear).norm(),
        })
    }

    /// Bins that are in the cell.
    pub(super) fn present(&self) -> impl Iterator<Item = (usize, Bin)> + '_ {
        let all = 0..self.setup.bins.len();
        all.filter_map(|bin| Some((bin, self.bin(bin)?)))
    }

    /// Bins that stand where they belong, with their places.
    pub(super) fn placed(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let seen = self
            .present()
            .filter(|(bin, _)| Some(*bin) != self.attached);
        seen.filter_map(|(bin, seen)| Some((bin, self.slot_of(&seen)?)))
    }

    /// The place a bin stands in.
    pub(super) fn slot_of(&self, bin: &Bin) -> Option<usize> {
        let tolerance = self.setup.numbers.slot_tolerance_m;
        if bin.speed > STILL_M_S || lie(&bin.pose) != Lie::Upright {
            return None;
        }
        let mut slots = self.setup.slots.iter();
        slots.position(|slot| {
            let off = bin.pose.translation.vector - slot.translation.vector;
            off.xy().norm() < tolerance && off.z.abs() < tolerance
        })
    }

    /// The place the bin on the cup goes to: the first that is free, of as many
    /// as the job needs.
    pub(super) fn free_slot(&self) -> Option<usize> {
        let slots = self.setup.slots.iter().enumerate();
        let mut free = slots.filter(|(_, slot)| {
            let mut others = self
                .present()
                .filter(|(bin, _)| Some(*bin) != self.attached);
            !others.any(|(_, bin)| {
                let off = bin.pose.translation.vector - slot.translation.vector;
                off.x.abs() < 0.5 * BESIDE_M
                    && off.y.abs() < BESIDE_M
                    && off.z.abs() < 2.0 * BESIDE_M
            })
        });
        free.next().map(|(slot, _)| slot)
    }

    /// As many bins stand on the pallet as shall.
    pub(super) fn complete(&self) -> bool {
        self.placed().count() >= self.setup.wanted
    }

    /// Whether a bin lies in the jig.
    pub(super) fn in_jig(&self, bin: &Bin) -> bool {
        let flip = &self.setup.numbers.flip;
        let off = bin.pose.translation.vector.xy() - nalgebra::Vector2::from(flip.jig_m);
        off.norm() < flip.jig_radius_m
    }

    /// Whether a bin lies where bins are taken off the belt.
    pub(super) fn at_belt_end(&self, bin: &Bin) -> bool {
        let numbers = &self.setup.numbers;
        within(bin.pose.translation.x, numbers.belt_x_m)
            && within(bin.pose.translation.y, numbers.belt_y_m)
    }

    /// Whether a bin is on the belt, or on its way on it.
    pub(super) fn on_belt(&self, bin: &Bin) -> bool {
        let numbers = &self.setup.numbers;
        within(bin.pose.translation.x, numbers.belt_x_m)
            && bin.pose.translation.y > numbers.belt_y_m[0]
            && !self.in_jig(bin)
    }

    /// The bin to take next: one in the jig, then one that stands on the pallet
    /// but not in its place, then the first at the end of the belt.
    pub(super) fn next_bin(&self) -> Option<usize> {
        let loose = || {
            self.present()
                .filter(|(_, bin)| self.slot_of(bin).is_none())
        };
        let jig = loose().find(|(_, bin)| self.in_jig(bin));
        let stray = || {
            loose()
                .find(|(_, bin)| bin.speed < STILL_M_S && !self.on_belt(bin) && !self.in_jig(bin))
        };
        let belt = || {
            let waiting = loose().filter(|(_, bin)| self.at_belt_end(bin) && !self.in_jig(bin));
            waiting.min_by(|(_, a), (_, b)| a.pose.translation.y.total_cmp(&b.pose.translation.y))
        };
        let found = jig.or_else(stray).or_else(belt);
        found.map(|(bin, _)| bin)
    }
}

fn within(value: f64, [low, high]: [f64; 2]) -> bool {
    value > low && value < high
}
