//! What a node of the tree sees and moves: one arm, the cubes, the log.

use behavior::tree::{Cx, Host};
use ipc_types::decision::GoalKind;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{GripperGoal, Pose};
use nalgebra::{Vector2, Vector3};

use super::setup::{ArmSetup, PyramidSetup};
use crate::stack::geometry;
use robocell_task::job::Counters;
use robocell_task::observation::Observation;
use robocell_task::output::{ArmIntent, Output};

/// An arm whose controller was silent for longer does not work (ticks of 1 ms).
const ECHO_LIMIT_TICKS: u64 = 100;
/// A cube further than this many edges from the TCP is not between the fingers:
/// half of its diagonal and what a pull may shift it by.
const IN_HAND_EDGES: f64 = 1.0;
/// Fingers nearer than this many cube edges stand closed around a cube or on
/// nothing: one, and a tilt.
const CLOSED_EDGES: f64 = 1.2;

/// Share of the way from its base to its stack at which an arm rests.
const REST_SHARE: f64 = 0.75;
/// How far beside that, away from the other arms (m).
const REST_ASIDE_M: f64 = 0.12;
/// How far above the height cubes are lifted to (m).
const REST_ABOVE_M: f64 = 0.1;

/// Marks trees of this demo.
pub struct PyramidHost;

impl Host for PyramidHost {
    type World<'w> = World<'w>;
}

/// What a node gets with each call.
pub(super) type Context<'a, 'w> = Cx<'a, 'w, PyramidHost>;

/// The part of the cell one tree works with.
pub struct World<'w> {
    /// What is seen.
    pub observation: &'w Observation<'w>,
    /// The job.
    pub setup: &'w PyramidSetup,
    /// Which arm the tree moves.
    pub arm: usize,
    /// Key of the newest goal of any arm; see [`ArmIntent::key`].
    pub last_key: &'w mut u64,
    /// What happened so far.
    pub counters: &'w mut Counters,
    /// Where the arm's goal and the log go.
    pub out: &'w mut Output,
}

impl<'w> World<'w> {
    /// The arm's part of the job; `None` for an arm that is not there.
    pub fn arm_setup(&self) -> Option<&'w ArmSetup> {
        self.setup.arms.get(self.arm)
    }

    /// Whether the arm is seen, works, and its controller answers.
    pub fn is_alive(&self) -> bool {
        is_alive(self.observation, self.arm)
    }

    /// Measured TCP.
    pub fn tcp(&self) -> Option<Pose> {
        self.observation.tcp(self.arm)
    }

    /// Pose of a cube, `None` where it is not seen.
    pub fn cube(&self, cube: usize) -> Option<Pose> {
        let object = self
            .observation
            .object(self.setup.cubes.get(cube)?.object)?;
        let finite = object.pose.position.iter().all(|x| x.is_finite());
        (object.flags & OBJECT_ENABLED != 0 && finite).then_some(object.pose)
    }

    /// Centre of a cube (m).
    pub fn cube_position(&self, cube: usize) -> Option<Vector3<f64>> {
        self.cube(cube).map(|pose| Vector3::from(pose.position))
    }

    /// Distance of a cube's centre from the measured TCP (m).
    pub fn distance_to_tcp(&self, cube: usize) -> Option<f64> {
        let tcp = Vector3::from(self.tcp()?.position);
        Some((self.cube_position(cube)? - tcp).norm())
    }

    /// Distance of the fingers (m).
    pub fn width(&self) -> f64 {
        let arm = self.observation.arm(self.arm);
        arm.map_or(0.0, |a| a.gripper.width)
    }

    /// Whether the fingers stand open.
    pub fn is_open(&self) -> bool {
        let numbers = &self.setup.numbers;
        self.width() >= numbers.open_width_m - numbers.gripper_tolerance_m
    }

    /// The cube that `arm` holds: both fingers touch it, or it interrupts the
    /// beam between fingers that were closed; and it is where the fingers are.
    pub fn cube_in_hand_of(&self, arm: usize) -> Option<usize> {
        let gripper = self.observation.arm(arm)?.gripper;
        let edge = self.setup.numbers.layer_height_m;
        let closed = gripper.width < CLOSED_EDGES * edge
            && self
                .out
                .previous(arm)
                .is_some_and(|p| p.gripper != GripperGoal::Open);
        let seen = match (gripper.held_object, gripper.beam_object) {
            (held, _) if held > 0 => held,
            (_, beam) if beam > 0 && closed => beam,
            _ => return None,
        };
        let cube = self.setup.cube_of_object(seen as usize - 1)?;
        let tcp = Vector3::from(self.observation.tcp(arm)?.position);
        ((self.cube_position(cube)? - tcp).norm() < IN_HAND_EDGES * edge).then_some(cube)
    }

    /// The cube in this arm's hand.
    pub fn cube_in_hand(&self) -> Option<usize> {
        self.cube_in_hand_of(self.arm)
    }

    /// Whether any arm holds a cube.
    pub fn is_held(&self, cube: usize) -> bool {
        (0..self.setup.arms.len()).any(|arm| self.cube_in_hand_of(arm) == Some(cube))
    }

    /// A key for a new goal.
    pub fn new_key(&mut self) -> u64 {
        *self.last_key += 1;
        *self.last_key
    }

    /// Sends the TCP to `target`.
    pub fn go(&mut self, key: u64, target: Pose, gripper: GripperGoal) {
        let intent = ArmIntent {
            kind: GoalKind::Pose,
            gripper,
            key,
            target,
            grip_force: self.setup.numbers.grip_force_n,
            ..ArmIntent::default()
        };
        self.out.arm(self.arm, intent);
    }

    /// Moves the fingers, and the arm stays with the target it has.
    pub fn grip(&mut self, gripper: GripperGoal) {
        let mut intent = ArmIntent {
            gripper,
            grip_force: self.setup.numbers.grip_force_n,
            ..ArmIntent::default()
        };
        if let Some(previous) = self.out.previous(self.arm)
            && previous.kind == GoalKind::Pose
        {
            intent.kind = GoalKind::Pose;
            intent.key = previous.key;
            intent.target = previous.target;
        }
        self.out.arm(self.arm, intent);
    }

    /// Whether the goal sent under `key` is followed and the measured TCP is
    /// within `position` (m) and `orientation` (rad) of `target`. What was asked
    /// for under another key says nothing.
    pub fn has_reached(&self, key: u64, target: &Pose, position: f64, orientation: f64) -> bool {
        let sent = self.out.previous(self.arm).filter(|p| p.key == key);
        let echo = self.observation.echo(self.arm);
        let followed = match (sent, echo) {
            (Some(sent), Some(echo)) => echo.goal_active && echo.goal_id == sent.goal_id,
            _ => false,
        };
        let near = self.tcp().is_some_and(|tcp| {
            let offset = Vector3::from(tcp.position) - Vector3::from(target.position);
            let angle = geometry::angle_between(tcp.orientation_wxyz, target.orientation_wxyz);
            offset.norm() < position && angle < orientation
        });
        followed && near
    }

    /// Where the TCP is out of everybody's way: back from the arm's stack, on
    /// the side away from the other arms, above all cubes.
    pub fn rest(&self) -> Option<Pose> {
        let arm = self.arm_setup()?;
        let others = self
            .setup
            .arms
            .iter()
            .filter(|other| other.name != arm.name);
        let away: Vector2<f64> = others.map(|other| arm.goal - other.goal).sum();
        let away = away.try_normalize(1.0e-6).unwrap_or_default();
        let place = arm.base + (arm.goal - arm.base) * REST_SHARE + away * REST_ASIDE_M;
        Some(Pose {
            position: [place.x, place.y, self.setup.numbers.lift_z_m + REST_ABOVE_M],
            orientation_wxyz: geometry::straight_down(arm.yaw),
        })
    }

    /// Name of the arm for the log.
    pub fn name(&self) -> &'w str {
        self.arm_setup().map_or("", |a| a.name.as_str())
    }
}

/// Whether `arm` is seen, has no fault, and its controller answers.
pub(super) fn is_alive(observation: &Observation<'_>, arm: usize) -> bool {
    let works = observation.arm(arm).is_some_and(|a| a.fault == 0);
    let heard = observation
        .echo(arm)
        .is_some_and(|echo| observation.sample_id().saturating_sub(echo.tick) <= ECHO_LIMIT_TICKS);
    works && heard
}
