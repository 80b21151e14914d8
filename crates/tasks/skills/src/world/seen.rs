//! The objects and the gripper as the arm observes them.

use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_task::job::Placement;

use super::World;
use crate::geometry;
use crate::setup::Tool;

/// A gripped object is nearer to the TCP than this many of its heights: half of its diagonal,
/// and the distance by which a pull may shift it.
const IN_GRIPPER_HEIGHTS: f64 = 1.0;
/// An object farther from the TCP than this many of its heights has left the gripper.
pub(super) const LEFT_HEIGHTS: f64 = 1.5;
/// An object nearer to a slot than this many of its heights is in the way.
const BLOCKED_HEIGHTS: f64 = 0.9;
/// Fingers nearer than this many heights of an object are closed around it.
const CLOSED_HEIGHTS: f64 = 1.2;
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
        let height = 2.0 * self.object_setup(object)?.half_height_m;
        let tcp = Vector3::from(self.observation.tcp(arm)?.position);
        let told = self.out.previous(arm);
        let closed = gripper.width < CLOSED_HEIGHTS * height
            && gripper.width_velocity < OPENING_M_S
            && told.is_some_and(|told| told.gripper != GripperGoal::Open);
        let near = (self.position(object)? - tcp).norm() < IN_GRIPPER_HEIGHTS * height;
        (closed && near).then_some(object)
    }

    /// Whether any arm holds an object.
    pub fn is_held(&self, object: usize) -> bool {
        (0..self.setup.arms.len()).any(|arm| self.held_by(arm) == Some(object))
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
        let Some(arm) = self.observation.arm(self.arm) else {
            return false;
        };
        match self.tool() {
            Tool::Fingers {
                open_width_m,
                open_tolerance_m,
                ..
            } => arm.gripper.width >= open_width_m - open_tolerance_m,
            Tool::Suction => arm.gripper.attached == 0 && arm.gripper.suction == 0,
            Tool::None => true,
        }
    }

    /// Whether the arm reaches a point with the tool straight down (m).
    pub fn reaches(&self, point: Vector3<f64>) -> bool {
        self.arm_setup().is_some_and(|arm| arm.reaches(point))
    }

    /// Whether an object is in no gripper, its centre nearer to `point` in the plane than
    /// `tolerance_m`, and in that layer.
    pub fn is_at(&self, object: usize, point: Vector3<f64>, tolerance_m: f64) -> bool {
        let half = self.object_setup(object).map_or(0.0, |o| o.half_height_m);
        self.position(object).is_some_and(|position| {
            let off = position - point;
            off.xy().norm() < tolerance_m && off.z.abs() < half
        }) && !self.is_held(object)
    }

    /// The slot of a place that an object is in, held by no gripper; nearer than `tolerance_m`
    /// in the plane, and in that layer.
    pub fn slot_of(&self, object: usize, place: usize, tolerance_m: f64) -> Option<usize> {
        let slots = self.setup.places.get(place)?.slots.len();
        (0..slots).find(|slot| {
            let goal = self.setup.goal(object, place, *slot);
            goal.is_some_and(|goal| self.is_at(object, goal.position.into(), tolerance_m))
        })
    }

    /// The first slot of a place without another object.
    pub fn free_slot(&self, object: usize, place: usize, tolerance_m: f64) -> Option<usize> {
        let slots = self.setup.places.get(place)?.slots.len();
        let others = (0..self.setup.objects.len()).filter(|other| *other != object);
        // A place has at most 64 slots, so the mask has a bit for each.
        let taken = others
            .filter_map(|other| self.slot_of(other, place, tolerance_m))
            .fold(0_u64, |taken, slot| taken | 1 << slot.min(63));
        (0..slots).find(|slot| taken >> slot.min(&63) & 1 == 0)
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
            position.is_some_and(|position| (position - tcp).norm() < LEFT_HEIGHTS * height)
        })
    }

    /// An object, other than `object` and the held ones, at the position of a slot's object,
    /// though it is in no slot.
    pub fn blocks(&self, goal: Placement, object: usize) -> Option<usize> {
        let goal = Vector3::from(goal.position);
        let others = 0..self.setup.objects.len();
        others.filter(|other| *other != object).find(|other| {
            let height = self
                .object_setup(*other)
                .map_or(0.0, |other| 2.0 * other.half_height_m);
            let off = self.position(*other).map(|position| position - goal);
            !self.is_held(*other)
                && off.is_some_and(|off| {
                    off.xy().norm() < BLOCKED_HEIGHTS * height && off.z.abs() < 0.7 * height
                })
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

    /// The TCP that brings the object in the gripper to `goal`, given its present pose in the
    /// gripper, with the tool turned as little as possible.
    pub fn place_pose(&self, object: usize, goal: Placement) -> Option<Pose> {
        self.place_pose_turned(object, goal, self.tool_yaw())
    }

    /// As [`World::place_pose`], with the tool turned to near `reference` (rad).
    pub fn place_pose_turned(
        &self,
        object: usize,
        goal: Placement,
        reference: f64,
    ) -> Option<Pose> {
        let (tcp, pose) = (self.tcp()?, self.object(object)?);
        let in_gripper = Vector3::from(pose.position) - Vector3::from(tcp.position);
        let turned = self.tool_yaw();
        // The object's turn in the gripper is measured: fingers seldom close on it exactly
        // straight.
        let wanted = goal.yaw - (geometry::yaw(&pose) - turned);
        let yaw = geometry::nearest_quarter(wanted, reference);
        let shift = geometry::turned(in_gripper.xy(), yaw - turned);
        let [x, y, z] = goal.position;
        Some(Pose {
            position: [x - shift.x, y - shift.y, z - in_gripper.z],
            orientation_wxyz: self.tool().down(yaw),
        })
    }
}
