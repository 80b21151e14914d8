//! Where the tool sets the object in the gripper down.

use grasp::{Exclusion, Gripper, SetDown, set_down};
use ipc_types::Pose;
use nalgebra::{Isometry3, Translation3};
use robocell_task::job::Placement;

use crate::condition::PLACE_TOLERANCE_M;
use crate::pose::{isometry, wire};
use crate::world::World;

/// Heights from which an object is let go (m): one that has slipped in the hand would bring the
/// finger tips to the table before it is down.
const RAISED_M: [f64; 3] = [0.0, 0.002, 0.005];

/// Slots whose heights differ by less are in one layer (m).
const SAME_LAYER_M: f64 = 0.001;
/// Room between an object that is brought back and its neighbours (m).
const ROOM_M: f64 = 0.06;
/// Where an object is brought back to: to where it was, or beside that (in its own lengths, with
/// room).
const AROUND: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [-1.0, 0.0],
    [1.0, 0.0],
    [0.0, -1.0],
    [0.0, 1.0],
    [-1.0, -1.0],
    [-1.0, 1.0],
    [1.0, -1.0],
    [1.0, 1.0],
];

/// Further than they are apart fingers open to release an object beside neighbours (m).
const RELEASED_M: f64 = 0.012;

/// How an object is set down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Destination {
    /// The TCP, world frame.
    pub(crate) tcp: Isometry3<f64>,
    /// Distance to which the fingers open then (m).
    pub(crate) opening_m: f64,
}

/// Each height with each opening, the lowest and widest first.
fn raised(openings: &[f64]) -> impl Iterator<Item = (Translation3<f64>, f64)> + '_ {
    let heights = RAISED_M.map(|height| Translation3::new(0.0, 0.0, height));
    let with = |height| openings.iter().map(move |opening_m| (height, *opening_m));
    heights.into_iter().flat_map(with)
}

impl World<'_> {
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
        let ways = self.set_downs(object, goal, reference)?;
        ways.first().map(|(_, tcp)| wire(tcp))
    }

    /// The TCP that sets the object in the gripper down in the next free slot of a place, of
    /// all turns after which it looks the same the first that nothing excludes. A slot that
    /// another object blocks is left out, if there is another one in that layer.
    ///
    /// # Errors
    /// What excludes the first turn; `None` where no slot is free or the object is not in the
    /// cell.
    pub(crate) fn destination(
        &self,
        object: usize,
        place: usize,
    ) -> Result<Destination, Option<Exclusion>> {
        let mut first = None;
        let mut layer_m = None;
        for slot in self.free_slots(object, place, PLACE_TOLERANCE_M) {
            let goal = self.goal(object, place, slot).ok_or(None)?;
            // A slot above one that is not filled has no support.
            let height_m = goal.position[2];
            if (height_m - *layer_m.get_or_insert(height_m)).abs() > SAME_LAYER_M {
                continue;
            }
            match self.set_down_at(object, goal) {
                // Another object in the way may be in this slot only.
                Err(Some(Exclusion::Object(name))) => {
                    first = first.or(Some(Exclusion::Object(name)));
                }
                other => return other.map_err(|why| first.or(why)),
            }
        }
        Err(first)
    }

    /// The TCP that sets the object in the gripper down where it was at the start of the run, or
    /// near to it.
    ///
    /// # Errors
    /// `None` where nothing is free.
    pub(crate) fn way_back(&self, object: usize) -> Result<Destination, Option<Exclusion>> {
        let scene = self.setup.grasping.scene_at_start();
        let began = scene.and_then(|scene| scene.objects.get(object)?.pose);
        let setup = self.object_setup(object).ok_or(None)?;
        let [x, y, z] = began.ok_or(None)?.translation.vector.into();
        // The height of its present side above the same support.
        let z = z - setup.half_height_m + self.half_height(object);
        let room = setup.longest_m + ROOM_M;
        for [dx, dy] in AROUND {
            let goal = Placement {
                position: [x + dx * room, y + dy * room, z],
                yaw: self.tool_yaw(),
            };
            if let Ok(found) = self.set_down_at(object, goal) {
                return Ok(found);
            }
        }
        Err(None)
    }

    /// The TCP that sets the object in the gripper down at `goal`.
    fn set_down_at(
        &self,
        object: usize,
        goal: Placement,
    ) -> Result<Destination, Option<Exclusion>> {
        let ways = self.set_downs(object, goal, self.tool_yaw()).ok_or(None)?;
        let grasping = &self.setup.grasping;
        let scene = grasping.scene(self.arm, self.observation);
        let (gripper, scene) = grasping.gripper(self.arm).zip(scene).ok_or(None)?;
        let seen = self.observation.arm(self.arm);
        let width_m = seen.map_or(0.0, |arm| arm.gripper.width);
        let openings = match gripper {
            Gripper::Fingers(hand) => vec![hand.open_width_m, width_m + RELEASED_M],
            Gripper::Cup(_) => vec![0.0],
        };
        let mut first = None;
        for (raised, opening_m) in raised(&openings) {
            for (at, tcp) in &ways {
                let (at, tcp) = (raised * at, raised * tcp);
                let of = SetDown {
                    object,
                    width_m,
                    opening_m,
                    goal: &at,
                    tcp: &tcp,
                };
                let why = set_down(gripper, &scene, &of)
                    .or_else(|| (!self.is_reached(&tcp)).then_some(Exclusion::OutOfReach));
                match why {
                    None => return Ok(Destination { tcp, opening_m }),
                    Some(why) => first = first.or(Some(why)),
                }
            }
        }
        Err(first)
    }

    /// Poses of the object at `goal` that look the same, with their TCP; the tool turned to near
    /// `reference` (rad) first.
    fn set_downs(
        &self,
        object: usize,
        goal: Placement,
        reference: f64,
    ) -> Option<Vec<(Isometry3<f64>, Isometry3<f64>)>> {
        let (tcp, seen) = (isometry(&self.tcp()?), isometry(&self.object(object)?));
        let setup = self.object_setup(object)?;
        // As the gripper holds it: fingers seldom close on it exactly straight.
        let grip = seen.inverse() * tcp;
        let way = |rotation| {
            let at = Isometry3::from_parts(Translation3::from(goal.position), rotation);
            (at, at * grip)
        };
        let mut ways: Vec<_> = setup.at_rest(&seen.rotation, goal.yaw).map(way).collect();
        let tool = self.tool();
        let off = |tcp: &Isometry3<f64>| {
            let yaw = tool.yaw(wire(tcp).orientation_wxyz);
            let off = (yaw - reference).rem_euclid(std::f64::consts::TAU);
            // Rounded, so that the last bits of an angle decide nothing.
            (1.0e6 * off.min(std::f64::consts::TAU - off)).round()
        };
        ways.sort_by(|(_, a), (_, b)| off(a).total_cmp(&off(b)));
        Some(ways)
    }

    /// Whether the arm has joint positions that bring its TCP to `tcp`.
    fn is_reached(&self, tcp: &Isometry3<f64>) -> bool {
        self.setup
            .grasping
            .reaches(self.arm, self.joint_positions(), tcp)
    }

    /// Measured joint positions of the arm (rad or m); empty for one that is not observed.
    pub(crate) fn joint_positions(&self) -> &[f64] {
        let seen = self.observation.arm(self.arm);
        seen.map_or(&[], |arm| {
            let count = arm.joint_count as usize;
            arm.joint_positions.get(..count).unwrap_or_default()
        })
    }
}
