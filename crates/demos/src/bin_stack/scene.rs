//! What a decision sees of the bins.

use ipc_types::world::{OBJECT_DRAGGED, OBJECT_ENABLED};
use ipc_types::{GripperState, Pose};
use nalgebra::{Isometry3, Vector3};

use super::columns::{Occupied, Slot, UPSIDE_DOWN};
use super::setup::BinStackSetup;
use robocell_skills::pose;
use robocell_skills::setup::ARM;
use robocell_task::observation::Observation;

/// A bin slower than this is at rest (m/s, and rad/s).
const AT_REST: f64 = 0.02;
/// Two bins nearer than this in the plane lie one on the other, or may (m).
const BESIDE_M: f64 = 0.19;
/// A bin higher than this above another one lies on it (m).
const ABOVE_M: f64 = 0.05;
/// A bin further than this from the arm's axis cannot be picked (m).
const REACH_M: f64 = 1.2;

/// A bin as it is seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bin {
    pub(super) object: usize,
    pub(super) pose: Isometry3<f64>,
    pub(super) still: bool,
}

impl Bin {
    /// Height of its own z axis: 1 upright, -1 upside down.
    pub(super) fn up(&self) -> f64 {
        (self.pose.rotation * Vector3::z()).z
    }

    /// Flat on its bottom or on its rim.
    pub(super) fn flat(&self) -> bool {
        self.up().abs() > -UPSIDE_DOWN
    }

    fn position(&self) -> Vector3<f64> {
        self.pose.translation.vector
    }
}

/// One coherent look.
#[derive(Clone, Copy)]
pub(super) struct View<'a, 'o> {
    pub(super) setup: &'a BinStackSetup,
    observation: &'a Observation<'o>,
    pub(super) tcp: Pose,
    pub(super) gripper: &'o GripperState,
}

impl<'a, 'o> View<'a, 'o> {
    /// `None` where there is no arm to be seen.
    pub(super) fn read(setup: &'a BinStackSetup, observation: &'a Observation<'o>) -> Option<Self> {
        let arm = observation.arm(ARM)?;
        Some(Self {
            setup,
            observation,
            tcp: arm.tcp,
            gripper: &arm.gripper,
        })
    }

    /// The bins in the simulation.
    pub(super) fn bins(self) -> impl Iterator<Item = Bin> + use<'a, 'o> {
        let setup = self.setup;
        setup
            .bins
            .iter()
            .filter_map(move |object| self.bin(*object))
    }

    /// A bin, if it is in the simulation.
    pub(super) fn bin(self, object: usize) -> Option<Bin> {
        let state = self.observation.object(object)?;
        if state.flags & OBJECT_ENABLED == 0 || !self.setup.bins.contains(&object) {
            return None;
        }
        let slow = |v: [f64; 3]| Vector3::from(v).norm() < AT_REST;
        Some(Bin {
            object,
            pose: pose::isometry(&state.pose),
            still: slow(state.twist.linear)
                && slow(state.twist.angular)
                && state.flags & OBJECT_DRAGGED == 0,
        })
    }

    /// The bin in the hand.
    pub(super) fn held(self) -> Option<Bin> {
        let attached = self.gripper.attached == 1 && self.gripper.held_object > 0;
        let object = (self.gripper.held_object as usize).checked_sub(1)?;
        self.bin(object).filter(|_| attached)
    }

    /// Whether `bin` is gripped from its open side, inside.
    pub(super) fn inside(self, bin: &Bin) -> bool {
        let z = bin.pose.rotation * Vector3::z();
        pose::approach(&self.tcp).dot(&z) < 0.0
    }

    /// The slot of a bin that nobody holds.
    pub(super) fn slot(self, bin: &Bin) -> Option<Slot> {
        let held = self.held().is_some_and(|held| held.object == bin.object);
        let slot = self.setup.columns.slot_of(&bin.pose);
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

    /// Bins that stand where they belong, with no gap below them.
    pub(super) fn stacked(self) -> impl Iterator<Item = Bin> + use<'a, 'o> {
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
        (bin.still && bin.flat() && self.on_belt_end(&bin)).then_some(bin)
    }

    /// The object in the light barrier at the belt's end.
    fn sensed(self) -> Option<usize> {
        let sensors = self.observation.equipment().sensors;
        let object = *sensors.get(self.setup.sensor)?;
        (object as usize).checked_sub(1)
    }

    /// Whether a bin is at the belt's end, or hangs over it.
    pub(super) fn belt_end_taken(self) -> bool {
        self.sensed().is_some() || self.held().is_some_and(|bin| self.on_belt_end(&bin))
    }

    fn on_belt_end(self, bin: &Bin) -> bool {
        let task = &self.setup.task;
        let offset = bin.position() - Vector3::from(task.belt_end_position_m);
        let [x, y] = task.belt_end_m;
        // Low enough to be in the way of the next one, or on the belt itself.
        let low = offset.z < 2.5 * self.setup.height_m;
        offset.x.abs() < x && offset.y.abs() < y && low && offset.z > 0.0
    }

    /// A bin at rest, flat, free and in reach that is neither on the belt nor
    /// where it belongs: in the holder, or not placed well.
    pub(super) fn stray(self) -> Option<Bin> {
        let floor = self.setup.columns.spec().first_m[2];
        self.bins().find(|bin| {
            let at = bin.position();
            let far = at.xy().norm() > REACH_M;
            let lies = bin.still && bin.flat() && !far && at.z > floor;
            lies && !self.on_belt(bin) && self.slot(bin).is_none() && !self.covered(bin)
        })
    }

    /// A bin that belongs in no slot and that nobody can pick where it is.
    pub(super) fn on_belt(self, bin: &Bin) -> bool {
        let task = &self.setup.task;
        let end = Vector3::from(task.belt_end_position_m);
        let offset = bin.position() - end;
        offset.x.abs() < task.belt_end_m[0] && offset.y > -task.belt_end_m[1] && offset.z > 0.0
    }

    fn covered(self, bin: &Bin) -> bool {
        let at = bin.position();
        self.bins().any(|other| {
            let offset = other.position() - at;
            other.object != bin.object && offset.z > ABOVE_M && offset.xy().norm() < BESIDE_M
        })
    }

    /// Whether some joint of the arm has nearly no turn left.
    pub(super) fn caught(self) -> bool {
        const LEFT_RAD: f64 = 0.05;
        let Some(arm) = self.observation.arm(ARM) else {
            return false;
        };
        let joints = self.setup.joints.iter().zip(&arm.joint_positions);
        joints
            .into_iter()
            .any(|((lower, upper), q)| q - lower < LEFT_RAD || upper - q < LEFT_RAD)
    }
}
