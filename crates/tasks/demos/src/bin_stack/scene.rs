//! The bins as a decision sees them.

use ipc_types::{GripperState, Pose};
use nalgebra::{Isometry3, Vector3};
use robocell_skills::matrix::{ArmNumbers, Seen};
use robocell_skills::setup::ARM;
use robocell_skills::{Setup, pose};
use robocell_task::Observation;

use super::columns::{Occupied, Slot};
use super::job::{BinStack, BinStackNumbers, Turn};

/// Cosine of 40 degrees: a bin that leans by more cannot be gripped.
const TILTED: f64 = 0.766;

/// An observed bin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bin {
    pub(super) object: usize,
    pub(super) pose: Isometry3<f64>,
    pub(super) at_rest: bool,
}

impl Bin {
    /// The z component of the bin's z axis: 1 upright, -1 upside down.
    pub(super) fn up(&self) -> f64 {
        (self.pose.rotation * Vector3::z()).z
    }

    fn position(&self) -> Vector3<f64> {
        self.pose.translation.vector
    }

    /// Whether the cup, turned with the bin, reaches its bottom or floor.
    pub(super) fn can_be_gripped(&self) -> bool {
        self.up().abs() > TILTED
    }
}

/// The observation of one decision.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) of: &'a BinStack,
    setup: &'a Setup,
    pub(super) own: &'a BinStackNumbers,
    numbers: &'a ArmNumbers,
    observation: &'a Observation<'a>,
    tcp: Pose,
    gripper: &'a GripperState,
}

impl<'a> View<'a> {
    pub(super) fn of(turn: &Turn<'a>) -> Self {
        Self {
            of: turn.of,
            setup: turn.world.setup,
            own: turn.own,
            numbers: turn.numbers,
            observation: turn.world.observation,
            tcp: turn.tcp,
            gripper: turn.gripper,
        }
    }

    /// All bins in the simulation.
    pub(super) fn bins(self) -> impl Iterator<Item = Bin> + use<'a> {
        let bins = self.of.bins.iter();
        bins.filter_map(move |object| self.bin(*object))
    }

    /// A bin, if it is in the simulation.
    pub(super) fn bin(self, object: usize) -> Option<Bin> {
        let seen = Seen::of(self.numbers, self.observation, object)?;
        self.of.bins.contains(&object).then_some(Bin {
            object,
            pose: seen.pose,
            at_rest: seen.at_rest,
        })
    }

    /// Whether a bin rests on its bottom or on its rim.
    pub(super) fn is_flat(self, bin: &Bin) -> bool {
        bin.up().abs() > self.own.straight
    }

    /// The bin to pick next: the one that waits on the belt, or one that was left outside of
    /// its place.
    pub(super) fn candidate(self) -> Option<Bin> {
        // Strays first: one may be in the holder, which the next bin may need, or where the next
        // bin belongs.
        let next = self.stray().or_else(|| self.waiting())?;
        // Without a free slot no bin can be put anywhere.
        self.next_slot(&next).is_ok().then_some(next)
    }

    /// The slot for `bin` that is filled next.
    ///
    /// # Errors
    /// No slot is free: the first one that is empty, and the bin in its way, if there is any.
    pub(super) fn next_slot(self, bin: &Bin) -> Result<Slot, Option<(Slot, Bin)>> {
        let levels = self.of.columns.levels();
        let mut blocked = None;
        for slot in self.own.order.next(self.occupied(), levels) {
            match self.blocker(bin, slot) {
                None => return Ok(slot),
                Some(other) => blocked = blocked.or(Some((slot, other))),
            }
        }
        Err(blocked)
    }

    /// A bin outside of the slots, and in no gripper, that `bin` would touch in `slot` or on its
    /// way down to it.
    pub(super) fn blocker(self, bin: &Bin, slot: Slot) -> Option<Bin> {
        let is_loose = |other: &Bin| {
            let held = self.held().is_some_and(|held| held.object == other.object);
            !held && self.slot(other).is_none()
        };
        // Bins above a gap of a column are in its way, too.
        let above = |other: &Bin| {
            let its = self.slot(other);
            its.is_some_and(|its| its.column == slot.column && its.level >= slot.level)
        };
        let (columns, order) = (&self.of.columns, &self.own.order);
        columns.way_down(order, slot).find_map(|pose| {
            let others = self.bins().filter(|other| is_loose(other) || above(other));
            let others = others.map(|other| other.object);
            let found = self
                .setup
                .blocker(self.observation, (bin.object, &pose), others);
            found.and_then(|object| self.bin(object))
        })
    }

    /// The bin in the gripper.
    pub(super) fn held(self) -> Option<Bin> {
        let attached = self.gripper.attached == 1 && self.gripper.held_object > 0;
        let object = (self.gripper.held_object as usize).checked_sub(1)?;
        self.bin(object).filter(|_| attached)
    }

    /// Whether `bin` is gripped inside, from its open side.
    pub(super) fn inside(self, bin: &Bin) -> bool {
        let z = bin.pose.rotation * Vector3::z();
        pose::approach(&self.tcp).dot(&z) < 0.0
    }

    /// The slot of a bin, if it is not in the gripper.
    pub(super) fn slot(self, bin: &Bin) -> Option<Slot> {
        let held = self.held().is_some_and(|held| held.object == bin.object);
        let slot = self
            .of
            .columns
            .slot_of(&self.own.order, self.own.straight, &bin.pose);
        // A bin over its slot in the gripper is not placed; it would count as stacked before it
        // is released.
        slot.filter(|_| !held)
    }

    /// The slots that are taken.
    pub(super) fn occupied(self) -> Occupied {
        let mut taken = Occupied::default();
        for slot in self.bins().filter_map(|bin| self.slot(&bin)) {
            taken.take(slot);
        }
        taken
    }

    /// Bins in their slots without a gap below them.
    pub(super) fn stacked(self) -> impl Iterator<Item = Bin> + use<'a> {
        let taken = self.occupied();
        self.bins().filter(move |bin| {
            let slot = self.slot(bin);
            slot.is_some_and(|slot| slot.level < taken.height(slot.column))
        })
    }

    /// The bin that waits at the end of the belt.
    pub(super) fn waiting(self) -> Option<Bin> {
        let seen = self.sensed()?;
        let bin = self.bin(seen)?;
        // Moving bins are left alone: a spot that moves is missed by the cup.
        (bin.at_rest && self.is_flat(&bin) && self.on_belt_end(&bin)).then_some(bin)
    }

    /// The object in the light barrier at the belt's end.
    fn sensed(self) -> Option<usize> {
        let sensors = self.observation.equipment().sensors;
        let object = *sensors.get(self.of.sensor)?;
        (object as usize).checked_sub(1)
    }

    /// Whether a bin is at the belt's end, or held over it.
    pub(super) fn belt_end_taken(self) -> bool {
        self.sensed().is_some() || self.held().is_some_and(|bin| self.on_belt_end(&bin))
    }

    fn on_belt_end(self, bin: &Bin) -> bool {
        let task = &self.of.task;
        let offset = bin.position() - Vector3::from(task.belt_end_position_m);
        let [x, y] = task.belt_end_m;
        // Low enough to be in the way of the next bin, or on the belt itself.
        let low = offset.z < 2.5 * self.of.height_m;
        offset.x.abs() < x && offset.y.abs() < y && low && offset.z > 0.0
    }

    /// A bin at rest, free and in reach, not tilted too far, that is neither on the belt nor in a slot: in the
    /// holder, or placed badly.
    pub(super) fn stray(self) -> Option<Bin> {
        let floor = self.of.task.stack.first_m[2];
        let taken = self.occupied();
        // One above a gap of its column rests on a bin that does not belong there.
        let is_stacked = |bin: &Bin| {
            let slot = self.slot(bin);
            slot.is_some_and(|slot| slot.level < taken.height(slot.column))
        };
        self.bins().find(|bin| {
            let at = bin.position();
            let far = (at - self.of.base).xy().norm() > self.own.reach_m;
            let lies = bin.at_rest && bin.can_be_gripped() && !far && at.z > floor;
            // A bin below another one is not taken: the upper one would fall.
            lies && !self.on_belt(bin) && !is_stacked(bin) && !self.covered(bin)
        })
    }

    /// Whether a bin is on the belt, its end included.
    pub(super) fn on_belt(self, bin: &Bin) -> bool {
        let task = &self.of.task;
        let end = Vector3::from(task.belt_end_position_m);
        let offset = bin.position() - end;
        offset.x.abs() < task.belt_end_m[0] && offset.y > -task.belt_end_m[1] && offset.z > 0.0
    }

    fn covered(self, bin: &Bin) -> bool {
        let at = bin.position();
        self.bins().any(|other| {
            let offset = other.position() - at;
            other.object != bin.object
                && offset.z > self.own.on_top_m
                && offset.xy().norm() < self.own.beside_m
        })
    }

    /// Whether a joint of the arm is close to one of its limits.
    pub(super) fn caught(self) -> bool {
        let margin = self.own.joint_margin_rad;
        let Some(arm) = self.observation.arm(ARM) else {
            return false;
        };
        let joints = self.of.joints.iter().zip(&arm.joint_positions);
        joints
            .into_iter()
            .any(|((lower, upper), q)| q - lower < margin || upper - q < margin)
    }
}
