//! The seven poses a transfer goes through.

use behavior::board::{Access, Fault, Out};
use behavior::tree::{BindError, Binder};
use behavior::value::Set;
use ipc_types::Pose;
use nalgebra::{Rotation2, Vector2, Vector3};

use super::cubes::{is_clear, is_in_the_way, is_reachable, is_reachable_by_others};
use super::host::{Context, World};
use super::setup::ArmSetup;
use super::{grip, keys};
use crate::stack::geometry;

/// A pose as the blackboard keeps it: position (m) and quaternion w x y z.
pub(super) type Numbers = [f64; 7];

/// A node's hold of the targets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Targets {
    keys: [Out<Numbers>; 7],
    reference: Out<[f64; 3]>,
    aside: Out<bool>,
}

/// Where a cube goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Goal {
    /// Centre of the cube (m).
    pub(super) position: Vector3<f64>,
    /// It is put out of the way.
    pub(super) aside: bool,
}

impl Targets {
    pub(super) fn bind(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let mut key = |name: &str| keys::local::<Numbers>(binder, name, None, Access::Write);
        let [a, b, c, d, e, f, g] = keys::TARGETS;
        let keys = [
            key(a)?,
            key(b)?,
            key(c)?,
            key(d)?,
            key(e)?,
            key(f)?,
            key(g)?,
        ];
        Ok(Self {
            keys,
            reference: keys::local(binder, keys::PICKUP_REFERENCE, None, Access::Write)?,
            aside: keys::local(binder, keys::ASIDE, Some(false), Access::Write)?,
        })
    }

    /// Computes all targets for `cube` as it is seen. Nothing is written where
    /// that is impossible.
    pub(super) fn aim(
        &self,
        cx: &mut Context<'_, '_>,
        cube: usize,
        goal: Goal,
    ) -> Result<bool, Fault> {
        let (Some(arm), Some(pose)) = (cx.world.arm_setup(), cx.world.cube(cube)) else {
            return Ok(false);
        };
        let numbers = &cx.world.setup.numbers;
        let centre = Vector3::from(pose.position);
        let yaw = grip::choose(cx.world, arm, cube);
        let above = |place: Vector3<f64>, height: f64| place + Vector3::z() * height;
        let lift = Vector3::new(centre.x, centre.y, numbers.lift_z_m.max(centre.z));
        let poses = [
            down(above(centre, numbers.approach_m), yaw),
            down(above(centre, numbers.grasp_m), yaw),
            down(lift, yaw),
            down(above(goal.position, numbers.place_approach_m), arm.yaw),
            down(above(goal.position, numbers.place_m), arm.yaw),
            down(above(goal.position, numbers.retract_m), arm.yaw),
            standing(goal.position, arm.yaw),
        ];
        for (key, pose) in self.keys.iter().zip(&poses) {
            cx.set(key, to_numbers(pose))?;
        }
        cx.set(&self.reference, pose.position)?;
        cx.set(&self.aside, goal.aside)?;
        Ok(true)
    }

    /// Shifts the poses of the place by how `cube` lies in the hand.
    pub(super) fn calibrate(
        &self,
        cx: &mut Context<'_, '_>,
        cube: usize,
        goal: Goal,
    ) -> Result<bool, Fault> {
        let (Some(arm), Some(pose), Some(tcp)) =
            (cx.world.arm_setup(), cx.world.cube(cube), cx.world.tcp())
        else {
            return Ok(false);
        };
        let numbers = &cx.world.setup.numbers;
        let in_hand = Vector3::from(pose.position) - Vector3::from(tcp.position);
        let turned = geometry::tool_yaw(&tcp);
        let cube_in_hand = geometry::yaw(&pose) - turned;
        let yaw = geometry::nearest_quarter(arm.yaw - cube_in_hand, arm.yaw);
        let shift = turn(in_hand.xy(), yaw - turned);
        let at = |height: f64| {
            let centre = goal.position - Vector3::new(shift.x, shift.y, in_hand.z);
            down(centre + Vector3::z() * height, yaw)
        };
        let poses = [
            at(numbers.place_approach_m),
            at(numbers.place_m),
            at(numbers.retract_m),
            standing(goal.position, arm.yaw),
        ];
        for (key, pose) in self.keys.iter().skip(3).zip(&poses) {
            cx.set(key, to_numbers(pose))?;
        }
        cx.set(&self.aside, goal.aside)?;
        Ok(true)
    }

    /// Where the cube goes.
    pub(super) fn object_goal(&self, cx: &Context<'_, '_>) -> Result<Vector3<f64>, Fault> {
        let [.., goal] = &self.keys;
        let [x, y, z, ..] = cx.read(goal)?;
        Ok(Vector3::new(x, y, z))
    }

    /// Whether the cube goes out of the way.
    pub(super) fn is_aside(&self, cx: &Context<'_, '_>) -> Result<bool, Fault> {
        cx.read(&self.aside)
    }
}

/// Where `cube` goes: onto the arm's `stack`, or, while other cubes stand in
/// the way of that, to a clear place beside it.
pub(super) fn goal_of(world: &World<'_>, arm: &ArmSetup, stack: Set, cube: usize) -> Goal {
    let setup = world.setup;
    let on_stack = setup.goal(arm, stack.len());
    let blocked = (0..setup.cubes.len())
        .any(|other| other != cube && is_in_the_way(world, arm, stack, other));
    let edge = setup.numbers.layer_height_m;
    let beside = |[x, y]: &[f64; 2]| setup.goal(arm, 0) + Vector3::new(*x, *y, 0.0) * edge;
    let clear = |place: &Vector3<f64>| {
        is_clear(world, *place, cube)
            && is_reachable(world, *place)
            && (place.xy() - arm.base).norm() > TOO_NEAR_M
    };
    // Best where other arms reach the cube, too: they may need it.
    let places = || BESIDE_EDGES.iter().map(beside).filter(&clear);
    let aside = blocked
        .then(|| {
            places()
                .find(|place| is_reachable_by_others(world, *place))
                .or_else(|| places().next())
        })
        .flatten();
    Goal {
        position: aside.unwrap_or(on_stack),
        aside: aside.is_some(),
    }
}

/// Where to look for a clear place, seen from the stack (cube edges): in the
/// direction in which the fingers close there has to be more room than across it.
const BESIDE_EDGES: [[f64; 2]; 8] = [
    [2.8, 0.0],
    [0.0, -2.4],
    [0.0, 2.4],
    [-2.4, 0.0],
    [2.8, -2.4],
    [2.8, 2.4],
    [-2.4, -2.4],
    [-2.4, 2.4],
];
/// Nearer to its base the arm folds up and gets stuck (m).
const TOO_NEAR_M: f64 = 0.32;

/// The TCP at `position` with the tool straight down.
pub(super) fn down(position: Vector3<f64>, yaw: f64) -> Pose {
    Pose {
        position: position.into(),
        orientation_wxyz: geometry::straight_down(yaw),
    }
}

/// A cube standing at `position`.
fn standing(position: Vector3<f64>, yaw: f64) -> Pose {
    Pose {
        position: position.into(),
        orientation_wxyz: [libm::cos(yaw / 2.0), 0.0, 0.0, libm::sin(yaw / 2.0)],
    }
}

fn turn(offset: Vector2<f64>, angle: f64) -> Vector2<f64> {
    Rotation2::from_matrix_unchecked(nalgebra::Matrix2::new(
        libm::cos(angle),
        -libm::sin(angle),
        libm::sin(angle),
        libm::cos(angle),
    )) * offset
}

pub(super) fn to_numbers(pose: &Pose) -> Numbers {
    let [x, y, z] = pose.position;
    let [w, i, j, k] = pose.orientation_wxyz;
    [x, y, z, w, i, j, k]
}

pub(super) fn from_numbers([x, y, z, w, i, j, k]: Numbers) -> Pose {
    Pose {
        position: [x, y, z],
        orientation_wxyz: [w, i, j, k],
    }
}

/// Whether a set of cubes contains all of `count`.
pub(super) fn has(stack: Set, count: i64) -> bool {
    i64::from(stack.len()) >= count
}
