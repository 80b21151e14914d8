//! One arm of a cell in one decision: what it sees, and what it is told.

use ipc_types::decision::{GoalKind, MAX_PLACED, Outcome};
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_task::job::{Job, Placement};
use robocell_task::{ArmIntent, Observation, Output, PolicyTime, TraceEvent};
use serde::{Deserialize, Serialize};

use crate::condition::PLACE_TOLERANCE_M;
use crate::geometry;
use crate::progress::Step;
use crate::setup::{ArmSetup, ObjectSetup, Setup, Tool};
use crate::way::Way;

/// A gripped object is nearer to the TCP than this many of its heights: half of
/// its diagonal and what a pull may shift it by.
const IN_GRIPPER_HEIGHTS: f64 = 1.0;
/// An object further from the TCP than this many of its heights has left the
/// gripper.
const LEFT_HEIGHTS: f64 = 1.5;
/// An object nearer to a slot than this many of its heights is in the way.
const BLOCKED_HEIGHTS: f64 = 0.9;
/// Fingers nearer than this many heights of an object are closed around it.
const CLOSED_HEIGHTS: f64 = 1.2;
/// Fingers that are faster than this open (m/s).
const OPENING_M_S: f64 = 0.005;
/// Decisions in a row in which a grip has to be missed to count as lost:
/// contacts flicker while an object settles between the pads.
const LOST_DECISIONS: u32 = 5;
/// An object moves slower than this when it is at rest (m/s).
const REST_SPEED_M_S: f64 = 0.01;
/// Joints of an arm at rest are slower than this (rad/s or m/s).
const REST_JOINT_SPEED: f64 = 0.02;
/// A controller that was silent for longer does not work (ticks of 1 ms).
const ECHO_LIMIT_TICKS: u64 = 100;

/// What a policy of several arms remembers of each: a [`Job`] remembers one arm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArmMemory {
    /// Key of the newest goal.
    pub newest_key: u64,
    /// Object in the gripper.
    pub held: Option<usize>,
}

impl ArmMemory {
    /// Whether it can belong to a cell with so many objects.
    pub(crate) fn is_sound(&self, objects: usize) -> bool {
        self.newest_key < u64::MAX / 2 && self.held.is_none_or(|held| held < objects)
    }
}

/// The view of one arm in one decision.
pub struct World<'w> {
    /// The cell.
    pub setup: &'w Setup,
    /// What is seen.
    pub observation: &'w Observation<'w>,
    /// What happened so far.
    pub job: &'w mut Job,
    /// Where goals and the log go.
    pub out: &'w mut Output,
    /// Index of the arm.
    pub arm: usize,
    /// Whether this is the first decision after others were missed, or after the
    /// operator led the arm: what skills timed before it counts no more.
    pub resumed: bool,
    /// Of a policy of several arms. Without it the job counts the goals, and knows
    /// what the first arm holds.
    pub memory: Option<&'w mut ArmMemory>,
    acted: bool,
    /// What the gripper was told in this decision.
    gripper: GripperGoal,
}

/// A motion to one pose, as [`World::drive`] works it off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// TCP, world frame.
    pub target: Pose,
    /// Reached when nearer than this (m).
    pub tolerance_m: f64,
    /// And turned by less than this (rad).
    pub angle_rad: f64,
    /// And both for this long.
    pub settle: PolicyTime,
    /// What the gripper does meanwhile.
    pub gripper: GripperGoal,
    /// With more than 0 in a straight line: the arm follows a point that is this
    /// far ahead of it on the line (m).
    pub lead_m: f64,
    /// An object that is no obstacle for this motion.
    pub object: Option<usize>,
    /// Posture, corridor and obstacles.
    pub way: Way,
}

impl Drive {
    /// To `target`, not very exactly.
    pub fn travel(target: Pose, gripper: GripperGoal) -> Self {
        Self {
            target,
            tolerance_m: 0.02,
            angle_rad: 0.05,
            settle: PolicyTime::from_ticks(100),
            gripper,
            lead_m: 0.0,
            object: None,
            way: Way::default(),
        }
    }

    /// To `target` at an object: exactly, in a straight line, and at rest before
    /// the gripper closes. A cup that still moves down would push itself off.
    pub fn grasp(target: Pose, gripper: GripperGoal) -> Self {
        Self {
            settle: PolicyTime::from_ticks(500),
            ..Self::precise(target, gripper)
        }
    }

    /// To `target`, exactly and in a straight line.
    pub fn precise(target: Pose, gripper: GripperGoal) -> Self {
        Self {
            tolerance_m: 0.004,
            settle: PolicyTime::from_ticks(150),
            lead_m: 0.08,
            ..Self::travel(target, gripper)
        }
    }

    /// Past an object that shall not count as an obstacle.
    #[must_use]
    pub fn near(mut self, object: Option<usize>) -> Self {
        self.object = object;
        self
    }
}

impl<'w> World<'w> {
    /// The view of `arm`.
    pub fn new(
        setup: &'w Setup,
        observation: &'w Observation<'w>,
        job: &'w mut Job,
        out: &'w mut Output,
        arm: usize,
    ) -> Self {
        Self {
            setup,
            observation,
            job,
            out,
            arm,
            resumed: false,
            memory: None,
            acted: false,
            gripper: GripperGoal::Keep,
        }
    }

    /// Policy time.
    pub fn now(&self) -> PolicyTime {
        self.observation.time()
    }

    /// The arm's part of the setup; `None` for an arm the cell does not have.
    pub fn arm_setup(&self) -> Option<&'w ArmSetup> {
        self.setup.arms.get(self.arm)
    }

    /// Name of the arm, for logs.
    pub fn arm_name(&self) -> &'w str {
        self.arm_setup().map_or("?", |arm| arm.name.as_str())
    }

    /// Whether the arm is seen, has no fault, and its controller answers.
    pub fn is_alive(&self) -> bool {
        let heard = self.observation.echo(self.arm).is_some_and(|echo| {
            self.observation.sample_id().saturating_sub(echo.tick) <= ECHO_LIMIT_TICKS
        });
        let arm = self.observation.arm(self.arm);
        heard && arm.is_some_and(|arm| arm.fault == 0)
    }

    /// What the arm grips with.
    pub fn tool(&self) -> Tool {
        self.arm_setup().map_or(Tool::None, |arm| arm.tool)
    }

    /// Measured TCP, world frame.
    pub fn tcp(&self) -> Option<Pose> {
        self.observation.tcp(self.arm)
    }

    /// Measured position of the TCP (m); the origin for an arm that is not seen.
    pub fn tcp_position(&self) -> Vector3<f64> {
        self.tcp()
            .map_or_else(Vector3::zeros, |tcp| tcp.position.into())
    }

    /// Turn of the measured tool about the vertical axis (rad).
    pub fn tool_yaw(&self) -> f64 {
        let tcp = self.tcp();
        tcp.map_or(0.0, |tcp| self.tool().yaw(tcp.orientation_wxyz))
    }

    /// Pose of an object; `None` where it is not in the cell.
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

    /// The object in the gripper: attached, or touched by both fingers, or in
    /// the light barrier between fingers that were closed; and at the TCP.
    pub fn held(&self) -> Option<usize> {
        self.held_by(self.arm)
    }

    /// The object in the gripper of an arm.
    pub fn held_by(&self, arm: usize) -> Option<usize> {
        let gripper = self.observation.arm(arm)?.gripper;
        if gripper.held_object > 0 {
            return Some(gripper.held_object as usize - 1);
        }
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

    /// Counts in `missed` for how many decisions in a row the arm has not held
    /// `object`; whether it is lost.
    pub fn is_lost(&self, object: usize, missed: &mut u32) -> bool {
        *missed = if self.held() == Some(object) {
            0
        } else {
            missed.saturating_add(1)
        };
        *missed >= LOST_DECISIONS
    }

    /// Whether an object that was in the gripper is further from the TCP than
    /// `distance_m`, or not in the cell any more.
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

    /// Whether an object is in no gripper, its centre nearer to `point` in the
    /// plane than `tolerance_m`, and in that layer.
    pub fn is_at(&self, object: usize, point: Vector3<f64>, tolerance_m: f64) -> bool {
        let half = self.object_setup(object).map_or(0.0, |o| o.half_height_m);
        self.position(object).is_some_and(|position| {
            let off = position - point;
            off.xy().norm() < tolerance_m && off.z.abs() < half
        }) && !self.is_held(object)
    }

    /// The slot of a place in which an object is, in no gripper; nearer than
    /// `tolerance_m` in the plane, and in that layer.
    pub fn slot_of(&self, object: usize, place: usize, tolerance_m: f64) -> Option<usize> {
        let slots = self.setup.places.get(place)?.slots.len();
        (0..slots).find(|slot| {
            let goal = self.setup.goal(object, place, *slot);
            goal.is_some_and(|goal| self.is_at(object, goal.position.into(), tolerance_m))
        })
    }

    /// The first slot of a place in which no other object is.
    pub fn free_slot(&self, object: usize, place: usize, tolerance_m: f64) -> Option<usize> {
        let slots = self.setup.places.get(place)?.slots.len();
        let others = (0..self.setup.objects.len()).filter(|other| *other != object);
        // A place has at most 64 slots.
        let taken = others
            .filter_map(|other| self.slot_of(other, place, tolerance_m))
            .fold(0_u64, |taken, slot| taken | 1 << slot.min(63));
        (0..slots).find(|slot| taken >> slot.min(&63) & 1 == 0)
    }

    /// An object other than `object` and what is held that is so near that the tool
    /// would drag it along on its way.
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

    /// An object, but for `object` and what is held, that is where a slot's object
    /// has to be, though it is in no slot.
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

    /// A key for a new goal; with one arm it is also a new entry into a phase.
    pub fn new_key(&mut self) -> u64 {
        if let Some(memory) = &mut self.memory {
            memory.newest_key += 1;
            return memory.newest_key;
        }
        self.job.counters.phase_entry += 1;
        u64::from(self.job.counters.phase_entry)
    }

    /// The TCP that grips an object with its centre at `at`, the tool straight
    /// down and `above_m` above the grip.
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

    /// The TCP that brings the object in the gripper to `goal`, as the object is
    /// in the gripper now, with the tool turned as little as possible.
    pub fn place_pose(&self, object: usize, goal: Placement) -> Option<Pose> {
        self.place_pose_turned(object, goal, self.tool_yaw())
    }

    /// As [`World::place_pose`], with the tool turned to about `reference` (rad).
    pub fn place_pose_turned(
        &self,
        object: usize,
        goal: Placement,
        reference: f64,
    ) -> Option<Pose> {
        let (tcp, pose) = (self.tcp()?, self.object(object)?);
        let in_gripper = Vector3::from(pose.position) - Vector3::from(tcp.position);
        let turned = self.tool_yaw();
        let wanted = goal.yaw - (geometry::yaw(&pose) - turned);
        let yaw = geometry::nearest_quarter(wanted, reference);
        let shift = geometry::turned(in_gripper.xy(), yaw - turned);
        let [x, y, z] = goal.position;
        Some(Pose {
            position: [x - shift.x, y - shift.y, z - in_gripper.z],
            orientation_wxyz: self.tool().down(yaw),
        })
    }

    /// Says what the arm shall do. What is said later in a decision replaces what
    /// was said before, but for the gripper, which keeps its last command.
    pub fn act(&mut self, intent: ArmIntent) {
        self.acted = true;
        if intent.gripper != GripperGoal::Keep {
            self.gripper = intent.gripper;
        }
        // Guides count for a motion that names them only.
        let obstacle_mask = match intent.obstacle_mask {
            u64::MAX => self.setup.solid_obstacles,
            mask => mask,
        };
        let intent = ArmIntent {
            obstacle_mask,
            gripper: self.gripper,
            grip_force: self.grip_force(),
            ..intent
        };
        self.out.arm(self.arm, intent);
    }

    /// The arm stays with the target it has, and the gripper does `gripper`.
    pub fn stay(&mut self, gripper: GripperGoal) {
        let mut intent = ArmIntent {
            gripper,
            ..ArmIntent::default()
        };
        if let Some(previous) = self.out.previous(self.arm)
            && previous.kind == GoalKind::Pose
        {
            intent.kind = GoalKind::Pose;
            intent.key = previous.key;
            intent.target = previous.target;
        }
        self.act(intent);
    }

    /// The arm stops where it is; the gripper keeps its command.
    pub fn hold(&mut self) {
        self.act(ArmIntent::default());
    }

    /// To be called at the end of a decision: an arm that no skill spoke for
    /// stays where it was sent, and a drop is counted: of the first arm, and of
    /// every arm with a [`World::memory`].
    pub fn finish(&mut self) {
        if !self.acted {
            self.stay(GripperGoal::Keep);
        }
        let before = match &self.memory {
            Some(memory) => memory.held,
            None => self.job.held.filter(|_| self.arm == 0),
        };
        let held = self.kept(before);
        if let Some(memory) = &mut self.memory {
            memory.held = held;
        }
        if self.arm == 0 {
            self.job.held = held;
        }
    }

    /// Says whether the job is done, and which objects are in a slot of a place.
    pub fn report(&mut self, done: bool) {
        self.report_within(done, PLACE_TOLERANCE_M);
    }

    /// As [`World::report`]; an object nearer to its slot than `tolerance_m` in the
    /// plane is in it.
    pub fn report_within(&mut self, done: bool, tolerance_m: f64) {
        self.job.done = done;
        self.out.outcome = if done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        self.job.placed.clear();
        for (number, object) in (0_u32..).zip(0..self.setup.objects.len()) {
            let mut places = 0..self.setup.places.len();
            let placed = places.any(|p| self.slot_of(object, p, tolerance_m).is_some());
            if placed && self.job.placed.len() < MAX_PLACED {
                self.job.placed.push(number);
            }
        }
    }

    /// Begins `step` unless it has begun, and after a resume counts its times
    /// again. Answers how long it has lasted.
    pub fn begin(&mut self, step: &mut Step) -> PolicyTime {
        let now = self.now();
        if !step.has_begun() || self.resumed {
            let key = match step.key {
                0 => self.new_key(),
                key => key,
            };
            *step = Step {
                key,
                began: now,
                settled: None,
                from: self.tcp_position().into(),
            };
        }
        now.since(step.began)
    }

    /// Sends the arm; whether it has settled at the target. A goal of another
    /// step says nothing about this one, and neither does a controller that has
    /// not answered this goal yet.
    pub fn drive(&mut self, step: &mut Step, drive: &Drive) -> bool {
        self.begin(step);
        let object_mask = drive
            .object
            .and_then(|o| self.object_setup(o)?.obstacle_bit);
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
        self.settles(step, there, drive.settle)
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

    /// Whether the arm is at rest at the target already, under whatever goal.
    pub fn is_there(&self, drive: &Drive) -> bool {
        let at_rest = self.observation.arm(self.arm).is_some_and(|arm| {
            let joints = arm.joint_velocities.iter().take(arm.joint_count as usize);
            joints
                .clone()
                .all(|velocity| velocity.abs() < REST_JOINT_SPEED)
        });
        at_rest && self.is_near(drive)
    }

    fn has_reached(&self, key: u64, drive: &Drive) -> bool {
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

    /// Where the arm is sent now on its way to the target.
    fn led(&self, step: &Step, drive: &Drive) -> Pose {
        let from = Vector3::from(step.from);
        let way = Vector3::from(drive.target.position) - from;
        let length = way.norm();
        if drive.lead_m <= 0.0 || length <= drive.lead_m {
            return drive.target;
        }
        let done = (self.tcp_position() - from).dot(&way) / length;
        let ahead = (done.max(0.0) + drive.lead_m).min(length);
        Pose {
            position: (from + way * (ahead / length)).into(),
            ..drive.target
        }
    }

    /// The object in the gripper. One that was there and is not seen for a moment
    /// stays, one that left a gripper that was not opened is counted as a drop.
    fn kept(&mut self, before: Option<usize>) -> Option<usize> {
        let held = self.held();
        let Some(before) = before.filter(|before| held != Some(*before)) else {
            return held;
        };
        let told = self.out.previous(self.arm).map(|told| told.gripper);
        if told == Some(GripperGoal::Open) {
            return held;
        }
        let height = self
            .object_setup(before)
            .map_or(0.0, |object| 2.0 * object.half_height_m);
        let left = self.has_left(before, LEFT_HEIGHTS * height);
        // A policy that opens now has noticed it, too.
        if held.is_none() && !left && self.gripper != GripperGoal::Open {
            return Some(before);
        }
        self.note_drop(before);
        held
    }

    /// Notes that something has to be done again.
    pub fn note_retry(&mut self, object: usize, why: &str) {
        self.job.counters.recoveries += 1;
        let setup = self.setup;
        let name = setup.object_name(object);
        self.out
            .event(TraceEvent::Recover, format_args!("[retry] {name} {why}"));
    }

    /// Gives the job up; the log says why.
    pub fn fail(&mut self, reason: &str, why: std::fmt::Arguments<'_>) {
        self.out
            .event(TraceEvent::Fault, format_args!("[failed] {why}"));
        self.job.fail(reason);
    }

    pub(crate) fn object_setup(&self, object: usize) -> Option<&'w ObjectSetup> {
        self.setup.objects.get(object)
    }

    fn grip_force(&self) -> f64 {
        match self.tool() {
            Tool::Fingers { force_n, .. } => force_n,
            Tool::Suction | Tool::None => 0.0,
        }
    }
}
