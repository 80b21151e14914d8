//! The notes of an arm on the blackboards: its cube, the seven poses of its transfer, and the
//! cubes in its stack.

use std::sync::Arc;

use behavior::Str;
use behavior::board::{Access, Fault, Out, Scope};
use behavior::tree::{BindError, Binder};
use behavior::value::{Plain, Set};
use ipc_types::Pose;
use nalgebra::Vector3;
use robocell_skills::nodes::Context;
use robocell_skills::shared;
use robocell_skills::{Lease, Owner, Recovery, Reservations};

use super::KEYS;
use super::look::{Goal, Look};
use super::setup::Pyramid;

/// Local keys: six poses of the TCP, and the goal of the cube.
pub(super) const TARGETS: [&str; 7] = [
    "approach",
    "grasp",
    "lift",
    "place_approach",
    "place",
    "retract",
    "object_goal",
];

/// A cube that was given up and is farther than this from where it was may be in reach again (m).
const MOVED_M: f64 = 0.01;

/// A pose as the blackboard stores it: position (m) and quaternion w x y z.
pub(super) type Numbers = [f64; 7];

/// Access of a node to all keys of its tree, and to the job.
pub(super) struct Notes {
    job: Arc<Pyramid>,
    pub(super) me: Str,
    pub(super) zone: Lease,
    pub(super) recovery: Recovery,
    owners: Reservations,
    current: Out<Str>,
    /// Recoveries of the current cube since it was reserved or lifted last.
    recoveries: Out<i64>,
    /// The cube that was given up last, and its position (m).
    given_up: Out<Str>,
    given_up_at: Out<[f64; 3]>,
    targets: [Out<Numbers>; 7],
    reference: Out<[f64; 3]>,
    aside: Out<bool>,
    placed: Out<Set>,
    complete: Out<bool>,
}

/// A key of the tree's own blackboard, declared here unless the file declares it.
#[allow(clippy::result_large_err, reason = "happens at load, once")]
pub(super) fn local<T: Plain>(
    binder: &mut Binder<'_>,
    key: &str,
    default: Option<T>,
) -> Result<Out<T>, BindError> {
    binder.writes(Scope::Local, key, default, Access::Write)
}

/// Name of the shared key for the complete stack of `robot`.
pub(super) fn complete_key(robot: Str) -> String {
    format!("stack_complete:{robot}")
}

impl Notes {
    #[allow(clippy::result_large_err, reason = "happens at load, once")]
    pub(super) fn bind(job: &Arc<Pyramid>, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let me = shared::robot(binder)?;
        let mut target = |name: &str| local(binder, name, None);
        let [a, b, c, d, e, f, g] = TARGETS.map(&mut target);
        let targets = [a?, b?, c?, d?, e?, f?, g?];
        Ok(Self {
            job: Arc::clone(job),
            me,
            zone: Lease::bind(binder, KEYS.zone)?,
            recovery: Recovery::bind(binder)?,
            owners: Reservations::bind(&job.setup, binder, KEYS.owners)?,
            current: local(binder, KEYS.object, Some(Str::EMPTY))?,
            recoveries: local(binder, "recoveries", Some(0))?,
            given_up: local(binder, "given_up", Some(Str::EMPTY))?,
            given_up_at: local(binder, "given_up_at", None)?,
            targets,
            reference: local(binder, KEYS.reference, None)?,
            aside: local(binder, "aside", Some(false))?,
            placed: shared::key(binder, &format!("placed:{me}"), Set::default())?,
            complete: shared::key(binder, &complete_key(me), false)?,
        })
    }

    /// The order in which the arm tries the cubes.
    pub(super) fn order(&self, arm: usize) -> &[usize] {
        self.job.orders.get(arm).map_or(&[], Vec::as_slice)
    }

    pub(super) fn look<'a, 'w>(&'a self, cx: &'a Context<'_, 'w>) -> Look<'a, 'w> {
        Look {
            job: &self.job,
            world: cx.world,
        }
    }

    /// The cube on which the tree works.
    pub(super) fn current(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        let name = cx.read(&self.current)?;
        Ok(cx.world.setup.object(name.as_str()))
    }

    pub(super) fn set_current(
        &self,
        cx: &mut Context<'_, '_>,
        cube: Option<usize>,
    ) -> Result<(), Fault> {
        let name = cube.map_or("", |cube| cx.world.setup.object_name(cube));
        cx.set(&self.recoveries, 0)?;
        cx.set(&self.current, Str::new(name).unwrap_or_default())
    }

    /// A cube's index in sets of cubes.
    pub(super) fn item(&self, cube: usize) -> u32 {
        self.job.item(cube)
    }

    /// Counts a recovery of the current cube; returns how many there were in a row.
    pub(super) fn count_recovery(&self, cx: &mut Context<'_, '_>) -> Result<i64, Fault> {
        let count = cx.read(&self.recoveries)?.saturating_add(1);
        cx.set(&self.recoveries, count)?;
        Ok(count)
    }

    /// Makes a cube that the arm cannot take available to all arms. This arm leaves it alone while
    /// it stays where it is, until [`Notes::try_again`].
    pub(super) fn give_up(&self, cx: &mut Context<'_, '_>, cube: usize) -> Result<(), Fault> {
        let name = cx.world.setup.object_name(cube);
        cx.set(&self.given_up, Str::new(name).unwrap_or_default())?;
        let at = cx.world.position(cube).unwrap_or_default();
        cx.set(&self.given_up_at, at.into())?;
        self.set_owner(cx, cube, Owner::Available)?;
        self.set_current(cx, None)
    }

    /// Whether a cube at a position (m) was given up and is still there.
    pub(super) fn is_given_up(
        &self,
        cx: &Context<'_, '_>,
        cube: usize,
        position: Vector3<f64>,
    ) -> Result<bool, Fault> {
        if cx.read(&self.given_up)?.as_str() != cx.world.setup.object_name(cube) {
            return Ok(false);
        }
        let before = Vector3::from(cx.read(&self.given_up_at)?);
        Ok((position - before).norm() < MOVED_M)
    }

    /// Every cube may be taken again.
    pub(super) fn try_again(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        cx.set(&self.given_up, Str::EMPTY)
    }

    /// The owner of an object; an object that is not a cube belongs to another.
    pub(super) fn owner(&self, cx: &Context<'_, '_>, object: usize) -> Result<Owner, Fault> {
        if self.job.cubes.contains(&object) {
            self.owners.owner(cx, object)
        } else {
            Ok(Owner::Other)
        }
    }

    pub(super) fn set_owner(
        &self,
        cx: &mut Context<'_, '_>,
        cube: usize,
        owner: Owner,
    ) -> Result<(), Fault> {
        self.owners.set(cx, cube, owner)
    }

    /// The object in the arm's gripper that belongs to another arm: it has to be released
    /// first.
    pub(super) fn held_of_another(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        match cx.world.held() {
            Some(held) if self.owner(cx, held)? == Owner::Other => Ok(Some(held)),
            _ => Ok(None),
        }
    }

    /// The arm's stack at the last comparison.
    pub(super) fn stack(&self, cx: &Context<'_, '_>) -> Result<Set, Fault> {
        cx.read(&self.placed)
    }

    /// Adds a cube to the arm's stack. Adding it again changes nothing.
    pub(super) fn add_to_stack(&self, cx: &mut Context<'_, '_>, cube: usize) -> Result<Set, Fault> {
        let stack = self.stack(cx)?.with(self.job.item(cube));
        cx.set(&self.placed, stack)?;
        self.set_owner(cx, cube, Owner::Placed)?;
        Ok(stack)
    }

    /// Takes a cube out of the arm's stack, to put it elsewhere.
    pub(super) fn remove_from_stack(
        &self,
        cx: &mut Context<'_, '_>,
        cube: usize,
    ) -> Result<Set, Fault> {
        let stack = self.stack(cx)?.without(self.job.item(cube));
        cx.set(&self.placed, stack)?;
        self.set_owner(cx, cube, Owner::Available)?;
        Ok(stack)
    }

    /// Compares the arm's stack with the observation and returns it: cubes that left it become
    /// available, available cubes in it become part of it.
    pub(super) fn compare(&self, cx: &mut Context<'_, '_>) -> Result<Set, Fault> {
        let before = self.stack(cx)?;
        let mut among = Set::default();
        for (item, cube) in self.job.items() {
            // Cubes that are reserved or carried pass over the stack; they are not part of it.
            if matches!(self.owner(cx, cube)?, Owner::Placed | Owner::Available) {
                among = among.with(item);
            }
        }
        let seen = self.look(cx).stack(among);
        for (item, cube) in self.job.items() {
            let is = seen.contains(item);
            // Only changes are written and logged: the comparison runs before every choice.
            if before.contains(item) == is {
                continue;
            }
            let (owner, verb) = if is {
                (Owner::Placed, "is in")
            } else {
                (Owner::Available, "left")
            };
            self.set_owner(cx, cube, owner)?;
            let (arm, name) = (self.me, cx.world.setup.object_name(cube));
            let out = &mut *cx.world.out;
            out.log(format_args!("[stack] {arm}: {name} {verb} the stack"));
        }
        cx.set(&self.placed, seen)?;
        Ok(seen)
    }

    /// Sets whether the stack is complete.
    pub(super) fn set_complete(
        &self,
        cx: &mut Context<'_, '_>,
        complete: bool,
    ) -> Result<(), Fault> {
        cx.set(&self.complete, complete)
    }

    /// Computes all targets for `cube` from its observed pose. Returns `None` and writes
    /// nothing if that is impossible.
    pub(super) fn aim(
        &self,
        cx: &mut Context<'_, '_>,
        cube: usize,
        stack: Set,
    ) -> Result<Option<Goal>, Fault> {
        let look = self.look(cx);
        let (Some(goal), Some(ways), Some(seen)) = (
            look.goal_of(stack, cube),
            look.ways(cube),
            cx.world.placement(cube),
        ) else {
            return Ok(None);
        };
        let task = &self.job.task;
        // With neighbours on all sides every other recovery tries the other grasp.
        let yaw = ways.choose(!ways.is_free() && cx.world.job.counters.recoveries % 2 == 1);
        let tool = cx.world.tool();
        let down = |[x, y, z]: [f64; 3], above: f64, yaw: f64| Pose {
            position: [x, y, z + above],
            orientation_wxyz: tool.down(yaw),
        };
        let (at, to) = (seen.position, goal.place.position);
        let pick = [
            down(at, task.approach_m, yaw),
            down(at, task.grasp_m, yaw),
            // Never below the cube: a cube above the height of lifts is not pushed down.
            down(at, (task.lift_z_m - at[2]).max(0.0), yaw),
        ];
        let heights = [task.place_approach_m, task.place_m, task.retract_m];
        let place = heights.map(|above| down(to, above, goal.place.yaw));
        for (key, pose) in self.targets.iter().zip(pick.iter().chain(&place)) {
            cx.set(key, to_numbers(pose))?;
        }
        self.set_goal(cx, goal)?;
        cx.set(&self.reference, seen.position)?;
        Ok(Some(goal))
    }

    /// Shifts and turns the poses of the place by the pose of `cube` in the gripper; `false` if
    /// that is not observed.
    pub(super) fn calibrate(
        &self,
        cx: &mut Context<'_, '_>,
        cube: usize,
        stack: Set,
    ) -> Result<bool, Fault> {
        let Some(goal) = self.look(cx).goal_of(stack, cube) else {
            return Ok(false);
        };
        // It is in the gripper, so the recoveries before have helped.
        cx.set(&self.recoveries, 0)?;
        let yaw = goal.place.yaw;
        let Some(pose) = cx.world.place_pose_turned(cube, goal.place, yaw) else {
            return Ok(false);
        };
        let task = &self.job.task;
        let heights = [task.place_approach_m, task.place_m, task.retract_m];
        // The three poses of the place only; those of the pick-up are past.
        for (key, above) in self.targets.iter().skip(3).zip(heights) {
            let mut pose = pose;
            pose.position[2] += above;
            cx.set(key, to_numbers(&pose))?;
        }
        self.set_goal(cx, goal)?;
        Ok(true)
    }

    fn set_goal(&self, cx: &mut Context<'_, '_>, goal: Goal) -> Result<(), Fault> {
        let half = 0.5 * goal.place.yaw;
        let cube = Pose {
            position: goal.place.position,
            orientation_wxyz: [libm::cos(half), 0.0, 0.0, libm::sin(half)],
        };
        let [.., key] = &self.targets;
        cx.set(key, to_numbers(&cube))?;
        cx.set(&self.aside, goal.aside)
    }

    /// The goal of the cube: its centre (m), and whether it is put out of the way.
    pub(super) fn goal(&self, cx: &Context<'_, '_>) -> Result<(Vector3<f64>, bool), Fault> {
        let [.., key] = &self.targets;
        let [x, y, z, ..] = cx.read(key)?;
        Ok((Vector3::new(x, y, z), cx.read(&self.aside)?))
    }

    /// The settings of the cell file.
    pub(super) fn task(&self) -> &super::numbers::PyramidTask {
        &self.job.task
    }
}

pub(super) fn to_numbers(pose: &Pose) -> Numbers {
    let [x, y, z] = pose.position;
    let [w, i, j, k] = pose.orientation_wxyz;
    [x, y, z, w, i, j, k]
}
