//! A motion to one pose: the goals on the way, and whether it has arrived.

use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_task::{ArmIntent, PolicyTime};

use super::World;
use crate::geometry;
use crate::progress::{REST, Step};
use crate::setup::Tool;
use crate::way::Way;

/// Joints of an arm at rest are slower than this (rad/s or m/s): at a distance of 1 m from a joint
/// the tool is then slower than 2 mm/s. At 5 mm/s the cup of a UR10 on an object on its support was
/// loaded by 12 N m within 16 ms as it locked.
const REST_JOINT_SPEED: f64 = 0.002;
/// How fast the goal of an object on a cup moves ahead of the arm at the start (m/s).
// The arm accelerates with that distance: a goal that is far ahead at once breaks the grip of a load
// that the cup can hold.
const CUP_LEAD_M_S: f64 = 0.16;
/// And how far at most (m).
const CUP_LEAD_M: f64 = 0.1;

/// A motion to one pose, for [`World::drive`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Goal of the TCP, world frame.
    pub target: Pose,
    /// Reached when nearer than this (m).
    pub tolerance_m: f64,
    /// And turned by less than this (rad).
    pub angle_rad: f64,
    /// And both for this time.
    pub settle: PolicyTime,
    /// And the tool is at rest for that time.
    pub at_rest: bool,
    /// Goal of the gripper during the motion.
    pub gripper: GripperGoal,
    /// If more than 0, the motion is a straight line: the arm follows a point that is this far
    /// ahead of it on the line (m).
    pub lead_m: f64,
    /// An object that is not an obstacle for this motion.
    pub object: Option<usize>,
    /// Posture, corridor and obstacles.
    pub way: Way,
}

impl Drive {
    /// A motion to `target`, not very exact.
    pub fn travel(target: Pose, gripper: GripperGoal) -> Self {
        Self {
            target,
            tolerance_m: 0.02,
            angle_rad: 0.05,
            settle: PolicyTime::from_ticks(100),
            at_rest: false,
            gripper,
            lead_m: 0.0,
            object: None,
            way: Way::default(),
        }
    }

    /// An exact motion to `target` in a straight line, and at rest there.
    pub fn precise(target: Pose, gripper: GripperGoal) -> Self {
        Self {
            tolerance_m: 0.004,
            at_rest: true,
            ..Self::straight(target, gripper)
        }
    }

    /// A motion to `target` in a straight line, not very exact.
    pub fn straight(target: Pose, gripper: GripperGoal) -> Self {
        Self {
            settle: REST,
            lead_m: 0.08,
            ..Self::travel(target, gripper)
        }
    }

    /// Leaves out an object that is not an obstacle.
    #[must_use]
    pub fn near(mut self, object: Option<usize>) -> Self {
        self.object = object;
        self
    }
}

impl World<'_> {
    /// Starts `step` unless it has started; after a resume its times start again. Returns how
    /// long it has lasted.
    pub fn begin(&mut self, step: &mut Step) -> PolicyTime {
        let now = self.now();
        if !step.has_begun() || self.resumed {
            // The key is kept after a resume: to the controller it is the same goal, so the arm
            // does not stop.
            let key = match step.key {
                0 => self.new_key(),
                key => key,
            };
            *step = Step {
                key,
                began: now,
                from: self.tcp_position().into(),
                ..Step::default()
            };
        }
        now.since(step.began)
    }

    /// Sends the arm; returns whether it has settled at the target. A goal of another step does
    /// not count, and neither does a controller that has not answered this goal yet.
    pub fn drive(&mut self, step: &mut Step, drive: &Drive) -> bool {
        self.begin(step);
        let object_mask = drive
            .object
            .and_then(|o| self.object_setup(o)?.obstacle_bit);
        // Judged before the command, by the feedback on the goal of the decision before.
        let there = self.has_reached(step.key, drive);
        self.act(ArmIntent {
            gripper: drive.gripper,
            object_mask: object_mask.map_or(u64::MAX, |bit| !(1 << bit)),
            posture: drive.way.posture,
            approach: drive.way.approach_m,
            approach_std_dev: drive.way.std_dev_m,
            obstacle_mask: drive.way.obstacle_mask(self.setup),
            ..ArmIntent::pose(step.key, self.led(step, drive))
        });
        let still = self.is_still(step);
        self.settles(step, there && (still || !drive.at_rest), drive.settle)
    }

    /// Whether the tool is at rest: it has moved by less than 0.3 mm for 0.15 s in `step`.
    pub(crate) fn rests(&self, step: &mut Step) -> bool {
        let still = self.is_still(step);
        self.settles(step, still, REST)
    }

    fn is_still(&self, step: &mut Step) -> bool {
        self.tcp().is_some_and(|tcp| step.is_still(&tcp))
    }

    /// Whether `holds` has been true in `step` for `settle`.
    pub fn settles(&self, step: &mut Step, holds: bool, settle: PolicyTime) -> bool {
        step.settles(holds, settle, self.now())
    }

    /// Whether the controller follows the goal sent under `key`.
    pub fn is_followed(&self, key: u64) -> bool {
        let sent = self.out.previous(self.arm).filter(|p| p.key == key);
        let echo = self.observation.echo(self.arm);
        sent.zip(echo)
            .is_some_and(|(sent, echo)| echo.goal_active && echo.goal_id == sent.goal_id)
    }

    /// Whether the arm is at rest at the target, whatever its goal.
    pub fn is_there(&self, drive: &Drive) -> bool {
        self.arm_is_at_rest() && self.is_near(drive)
    }

    /// Whether the joints of the arm are at rest.
    pub fn arm_is_at_rest(&self) -> bool {
        self.observation.arm(self.arm).is_some_and(|arm| {
            let joints = arm.joint_velocities.iter().take(arm.joint_count as usize);
            joints
                .clone()
                .all(|velocity| velocity.abs() < REST_JOINT_SPEED)
        })
    }

    fn has_reached(&self, key: u64, drive: &Drive) -> bool {
        // Followed, too: an arm that passes the target on the way to an older goal has not
        // reached it.
        self.is_near(drive) && self.is_followed(key)
    }

    fn is_near(&self, drive: &Drive) -> bool {
        self.tcp().is_some_and(|tcp| {
            let off = Vector3::from(tcp.position) - Vector3::from(drive.target.position);
            let angle =
                geometry::angle_between(tcp.orientation_wxyz, drive.target.orientation_wxyz);
            off.norm() < drive.tolerance_m && angle < drive.angle_rad
        })
    }

    /// The goal of the arm in this decision, on its way to the target.
    fn led(&self, step: &Step, drive: &Drive) -> Pose {
        let from = Vector3::from(step.from);
        let way = Vector3::from(drive.target.position) - from;
        let length = way.norm();
        let lead_m = self.lead_m(step, drive);
        if length <= lead_m {
            return drive.target;
        }
        // Never behind the start: an arm that was pushed back would be sent farther back.
        let done = (self.tcp_position() - from).dot(&way) / length;
        let ahead = (done.max(0.0) + lead_m).min(length);
        Pose {
            position: (from + way * (ahead / length)).into(),
            ..drive.target
        }
    }

    /// How far the goal is ahead of the arm.
    fn lead_m(&self, step: &Step, drive: &Drive) -> f64 {
        let most = match drive.lead_m {
            lead if lead > 0.0 => lead,
            _ => f64::INFINITY,
        };
        if self.tool() != Tool::Suction || drive.gripper != GripperGoal::Close {
            return most;
        }
        let lasted_s = self.now().since(step.began).ticks() as f64 * 1.0e-3;
        most.min(CUP_LEAD_M).min(lasted_s * CUP_LEAD_M_S)
    }
}
