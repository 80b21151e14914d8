//! The objects and the gripper as the arm observes them.

use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_task::job::Placement;

use super::World;
use crate::geometry;
use crate::setup::Tool;
use crate::setup::object::LEVEL_RAD;

/// A gripped object is nearer to the TCP than this share of its longest side: half of its
/// diagonal, and the distance by which a pull may shift it.
const IN_GRIPPER_SIDES: f64 = 1.0;
/// An object farther from the TCP than this many of its longest sides has left the gripper.
pub(super) const LEFT_SIDES: f64 = 1.5;
/// A tool nearer to an object than this many of its heights is beside it.
const BESIDE_HEIGHTS: f64 = 1.5;
/// Fingers nearer than this many widths of an object are closed around it.
const CLOSED_WIDTHS: f64 = 1.2;
/// Fingers faster than this are opening (m/s).
const OPENING_M_S: f64 = 0.005;
/// Decisions in a row in which a grip has to be missing to count as lost: contacts flicker
/// while an object settles between the pads.
const LOST_DECISIONS: u32 = 5;
/// An object slower than this is at rest (m/s).
const REST_SPEED_M_S: f64 = 0.01;

impl World<'_> {
    /// Pose of an object; `None` if it is not in the cell.
    pub fn object(&self, object: usize) -> Option<Pose> {
        let seen = self.observation.object(object)?;
        (seen.flags & OBJECT_ENABLED != 0).then_some(seen.pose)
    }

    /// Centre of an object (m).
    pub fn position(&self, object: usize) -> Option<Vector3<f64>> {
        self.object(object).map(|pose| pose.position.into())
    }

    /// Centre and turn of an object.
    pub fn placement(&self, object: usize) -> Option<Placement> {
        self.object(object).map(|pose| Placement {
            position: pose.position,
            yaw: geometry::yaw(&pose),
        })
    }

    /// Whether an object is at rest.
    pub fn is_at_rest(&self, object: usize) -> bool {
        let seen = self.observation.object(object);
        seen.is_some_and(|seen| Vector3::from(seen.twist.linear).norm() < REST_SPEED_M_S)
    }

    /// The object in the gripper: attached, touched by both fingers, or in the light barrier
    /// between closed fingers and near the TCP.
    pub fn held(&self) -> Option<usize> {
        self.held_by(self.arm)
    }

    /// The object in the gripper of an arm.
    pub fn held_by(&self, arm: usize) -> Option<usize> {
        let gripper = self.observation.arm(arm)?.gripper;
        if gripper.held_object > 0 {
            return Some(gripper.held_object as usize - 1);
        }
        // The light barrier helps where contacts flicker: it counts only for fingers that were
        // commanded to close and do not open.
        let object = (gripper.beam_object as usize).checked_sub(1)?;
        let pose = self.observation.tcp(arm)?;
        let closing = geometry::rotation(pose.orientation_wxyz) * Vector3::y();
        let (low, high) = self.extent(object, &closing)?;
        let longest = self.object_setup(object)?.longest_m;
        let tcp = Vector3::from(pose.position);
        let told = self.out.previous(arm);
        let closed = gripper.width < CLOSED_WIDTHS * (high - low)
            && gripper.width_velocity < OPENING_M_S
            && told.is_some_and(|told| told.gripper != GripperGoal::Open);
        let near = (self.position(object)? - tcp).norm() < IN_GRIPPER_SIDES * longest;
        (closed && near).then_some(object)
    }

    /// The least and the largest coordinate of an object along a unit `axis` (m, world frame).
    fn extent(&self, object: usize, axis: &Vector3<f64>) -> Option<(f64, f64)> {
        let pose = self.object(object)?;
        self.setup.grasping.extent(object, &pose, axis)
    }

    /// Half of the height of an object on its present side (m); upright for one that is not in the
    /// cell.
    pub(crate) fn half_height(&self, object: usize) -> f64 {
        let Some(setup) = self.object_setup(object) else {
            return 0.0;
        };
        let seen = self.object(object);
        seen.map_or(setup.half_height_m, |pose| setup.half_height_at(&pose))
    }

    /// Whether an object is not tilted: on a side, or level on a round one.
    fn is_level(&self, object: usize) -> bool {
        let setup = self.object_setup(object);
        let seen = setup.zip(self.object(object));
        seen.is_some_and(|(setup, pose)| setup.tilt(&pose) < LEVEL_RAD)
    }

    /// Whether any arm holds an object.
    pub fn is_held(&self, object: usize) -> bool {
        (0..self.setup.arms.len()).any(|arm| self.held_by(arm) == Some(object))
    }

    /// Whether any gripper holds an object or has not let go of it yet: fingers around it that are
    /// not open.
    pub fn is_in_hand(&self, object: usize) -> bool {
        let is_between = |arm: usize| {
            let gripper = self.observation.arm(arm).map(|arm| arm.gripper);
            let seen = gripper.is_some_and(|of| of.beam_object as usize == object + 1);
            seen && !self.is_open_of(arm) && self.is_near_tcp_of(arm, object)
        };
        (0..self.setup.arms.len()).any(|arm| self.held_by(arm) == Some(object) || is_between(arm))
    }

    /// Whether the centre of an object is as near to a TCP as in a gripper.
    fn is_near_tcp_of(&self, arm: usize, object: usize) -> bool {
        let longest = self.object_setup(object).map(|of| of.longest_m);
        let both = self.observation.tcp(arm).zip(self.position(object));
        both.zip(longest).is_some_and(|((tcp, its), longest)| {
            (its - Vector3::from(tcp.position)).norm() < IN_GRIPPER_SIDES * longest
        })
    }

    /// Counts in `missed` for how many decisions in a row the arm has not held `object`;
    /// returns whether it is lost.
    pub fn is_lost(&self, object: usize, missed: &mut u32) -> bool {
        *missed = if self.held() == Some(object) {
            0
        } else {
            missed.saturating_add(1)
        };
        *missed >= LOST_DECISIONS
    }

    /// Whether an object that was in the gripper is farther from the TCP than `distance_m`, or
    /// no longer in the cell.
    pub fn has_left(&self, object: usize, distance_m: f64) -> bool {
        self.position(object)
            .is_none_or(|position| (position - self.tcp_position()).norm() > distance_m)
    }

    /// Whether the gripper is open, or the suction off.
    pub fn is_open(&self) -> bool {
        self.is_open_of(self.arm)
    }

    fn is_open_of(&self, arm: usize) -> bool {
        let tool = self.setup.arms.get(arm).map_or(Tool::None, |arm| arm.tool);
        let told = self.out.previous(arm).map(|told| told.open_width);
        let Some(arm) = self.observation.arm(arm) else {
            return false;
        };
        match tool {
            Tool::Fingers {
                open_width_m,
                open_tolerance_m,
                ..
            } => {
                let wanted = told.filter(|width| *width > 0.0).unwrap_or(open_width_m);
                arm.gripper.width >= wanted - open_tolerance_m
            }
            Tool::Suction => arm.gripper.attached == 0 && arm.gripper.suction == 0,
            Tool::None => true,
        }
    }

    /// Whether the gripper is open, and its fingers are no farther apart than `width_m` (m; 0 for
    /// as far as they open).
    pub(crate) fn is_opened_to(&self, width_m: f64) -> bool {
        let measured = self
            .observation
            .arm(self.arm)
            .map_or(0.0, |arm| arm.gripper.width);
        let is_near = |tolerance: f64| width_m <= 0.0 || measured < width_m + tolerance;
        self.is_open()
            && match self.tool() {
                Tool::Fingers {
                    open_tolerance_m, ..
                } => is_near(open_tolerance_m),
                Tool::Suction | Tool::None => true,
            }
    }

    /// Whether the arm reaches a point with the tool straight down (m).
    pub fn reaches(&self, point: Vector3<f64>) -> bool {
        self.arm_setup().is_some_and(|arm| arm.reaches(point))
    }

    /// Whether an object is in no gripper, its centre nearer to `point` in the plane than
    /// `tolerance_m`, in that layer, and not tilted.
    pub fn is_at(&self, object: usize, point: Vector3<f64>, tolerance_m: f64) -> bool {
        let half = self.half_height(object);
        self.position(object).is_some_and(|position| {
            let off = position - point;
            off.xy().norm() < tolerance_m && off.z.abs() < half
        }) && self.is_level(object)
            && !self.is_in_hand(object)
    }

    /// The centre and turn of an object in a slot, on the side on which it is now; `None` for a
    /// slot or an object that does not exist.
    pub fn goal(&self, object: usize, place: usize, slot: usize) -> Option<Placement> {
        let slot = self.setup.places.get(place)?.slots.get(slot)?;
        self.object_setup(object)?;
        let [x, y, z] = slot.position;
        let position = [x, y, z + self.half_height(object)];
        Some(Placement { position, ..*slot })
    }

    /// The slot of a place that an object is in, held by no gripper; nearer than `tolerance_m`
    /// in the plane, and in that layer.
    pub fn slot_of(&self, object: usize, place: usize, tolerance_m: f64) -> Option<usize> {
        let slots = self.setup.places.get(place)?.slots.len();
        (0..slots).find(|slot| {
            let goal = self.goal(object, place, *slot);
            goal.is_some_and(|goal| self.is_at(object, goal.position.into(), tolerance_m))
        })
    }

    /// The first slot of a place without another object.
    pub fn free_slot(&self, object: usize, place: usize, tolerance_m: f64) -> Option<usize> {
        self.free_slots(object, place, tolerance_m).next()
    }

    /// The slots of a place without another object, in their order.
    pub(crate) fn free_slots(
        &self,
        object: usize,
        place: usize,
        tolerance_m: f64,
    ) -> impl Iterator<Item = usize> + use<> {
        let place_setup = self.setup.places.get(place);
        let slots = place_setup.map_or(0, |place| place.slots.len());
        let others = (0..self.setup.objects.len()).filter(|other| *other != object);
        // A place has at most 64 slots, so the mask has a bit for each.
        let taken = others
            .filter_map(|other| self.slot_of(other, place, tolerance_m))
            .fold(0_u64, |taken, slot| taken | 1 << slot.min(63));
        (0..slots).filter(move |slot| taken >> slot.min(&63) & 1 == 0)
    }

    /// An object other than `object` and the held one that is so near that the tool would drag
    /// it along.
    pub fn beside_tool(&self, object: Option<usize>) -> Option<usize> {
        let (tcp, held) = (self.tcp_position(), self.held());
        let others = (0..self.setup.objects.len()).filter(|other| Some(*other) != object);
        others.filter(|other| Some(*other) != held).find(|other| {
            let height = self
                .object_setup(*other)
                .map_or(0.0, |other| 2.0 * other.half_height_m);
            let position = self.position(*other);
            position.is_some_and(|position| (position - tcp).norm() < BESIDE_HEIGHTS * height)
        })
    }

    /// The TCP at the grip of an object with its centre at `at`, the tool straight down and
    /// `above_m` above the grip.
    pub fn grip_pose(&self, object: usize, at: Placement, above_m: f64) -> Pose {
        let height = self
            .object_setup(object)
            .map_or(0.0, |object| self.tool().grasp_height(object));
        let [x, y, z] = at.position;
        Pose {
            position: [x, y, z + height + above_m],
            orientation_wxyz: self.tool().down(at.yaw),
        }
    }
}
