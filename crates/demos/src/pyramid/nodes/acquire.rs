//! `AcquireCube`: takes the centre and reserves the next cube.

use robocell_task::TraceEvent;
use std::sync::Arc;

use behavior::Status;
use behavior::board::{Access, Fault, In, Out};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use behavior::value::Set;
use ipc_types::GripperGoal;
use serde::{Deserialize, Serialize};

use super::{Alarm, Turn};
use crate::pyramid::center::Center;
use crate::pyramid::cubes::{self, CubeState, Cubes};
use crate::pyramid::grip;
use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::keys::{self, Recovery};
use crate::pyramid::setup::PyramidSetup;
use crate::pyramid::targets::{Targets, goal_of};

/// An arm is at rest when it is as near as this (m).
const AT_REST_M: f64 = 0.05;
/// And turned by less than this (rad).
const AT_REST_RAD: f64 = 0.5;

/// See the module.
struct AcquireCube {
    warning: In<f64>,
    cubes: Cubes,
    center: Center,
    recovery: Recovery,
    complete: Out<bool>,
    targets: Targets,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    key: u64,
    turn: Turn,
    waiting: Alarm,
    /// The cube whose pose was not known at the last attempt.
    unseen: Option<usize>,
    /// The cube that was reserved last, kept from one pick-up to the next.
    last: Option<usize>,
}

/// The node type.
pub(in crate::pyramid) fn node_type(setup: &Arc<PyramidSetup>) -> NodeType<PyramidHost> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "AcquireCube",
        "Waits until no other arm owns the centre, takes it, reserves the next \
         free cube of the arm's order, and computes the seven targets. A cube \
         that is the arm's already, or in its hand, stays its cube.",
        move |binder| AcquireCube::new(&setup, binder),
    )
    .aliases(&["FrankaAcquireCube"])
    .keywords(&["reserve", "select", "lock", "next"])
    .input_or(
        "warning_interval",
        5.0,
        "a warning is given each time no cube was free for this long (s)",
    )
    .within(0.001, 3600.0)
}

impl AcquireCube {
    fn new(setup: &PyramidSetup, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let complete = keys::stack_complete(keys::robot(binder)?.as_str());
        Ok(Self {
            warning: binder.input("warning_interval")?,
            cubes: Cubes::bind(setup, binder)?,
            center: Center::bind(binder)?,
            recovery: Recovery::bind(binder)?,
            complete: keys::shared(binder, &complete, false, Access::Write)?,
            targets: Targets::bind(binder)?,
        })
    }

    /// The cube that is the arm's already: in its hand, or reserved before.
    fn own(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        if let Some(held) = cx.world.cube_in_hand()
            && self.cubes.state(cx, held)? != CubeState::Others
        {
            return Ok(Some(held));
        }
        let Some(current) = self.cubes.current(cx)? else {
            return Ok(None);
        };
        let state = self.cubes.state(cx, current)?;
        Ok(matches!(state, CubeState::Reserved | CubeState::Carried).then_some(current))
    }

    /// The next cube: one that stands in the way of the stack first, then those
    /// the fingers get around (of those they do not, another than the last),
    /// then those that only this arm reaches, then by the order. In a pyramid
    /// nobody touched the order alone decides.
    fn next(
        &self,
        state: &State,
        cx: &Context<'_, '_>,
        stack: Set,
    ) -> Result<Option<usize>, Fault> {
        let Some(arm) = cx.world.arm_setup() else {
            return Ok(None);
        };
        let mut best: Option<([bool; 4], usize)> = None;
        for cube in &arm.order {
            if self.cubes.state(cx, *cube)? != CubeState::Available {
                continue;
            }
            let Some(position) = cx.world.cube_position(*cube) else {
                // Its turn has come, and it cannot be seen.
                return Ok(Some(best.map_or(*cube, |(_, cube)| cube)));
            };
            let ready = cubes::is_reachable(cx.world, position)
                && cubes::is_free_on_top(cx.world, *cube)
                && !cx.world.is_held(*cube)
                && !cubes::is_at_another_hand(cx.world, position);
            let crowded = !grip::is_free(cx.world, arm, *cube);
            let worse = [
                !cubes::is_in_the_way(cx.world, arm, stack, *cube),
                crowded,
                crowded && state.last == Some(*cube),
                cubes::is_reachable_by_others(cx.world, position),
            ];
            if ready && best.is_none_or(|(least, _)| worse < least) {
                best = Some((worse, *cube));
            }
        }
        Ok(best.map(|(_, cube)| cube))
    }

    fn reserve(
        &self,
        state: &mut State,
        cx: &mut Context<'_, '_>,
        cube: usize,
        stack: Set,
    ) -> Result<Status, Fault> {
        let name = cx.world.setup.cube_name(cube);
        let arm = self.cubes.me();
        let goal = match cx.world.arm_setup() {
            Some(arm) => goal_of(cx.world, arm, stack, cube),
            None => return Ok(Status::Failure),
        };
        if !self.targets.aim(cx, cube, goal)? {
            // Said once, however often it is tried.
            if state.unseen.replace(cube) != Some(cube) {
                cx.world.out.event(
                    TraceEvent::Fault,
                    format_args!("[error] {arm}: the pose of {name} is not known"),
                );
            }
            return Ok(Status::Failure);
        }
        state.unseen = None;
        self.recovery.clear(cx)?;
        if !cx.is_set(&self.complete) {
            cx.set(&self.complete, false)?;
        }
        self.center.take(cx)?;
        if self.cubes.current(cx)? != Some(cube) || self.is_free(cx, cube)? {
            self.cubes.set_state(cx, cube, CubeState::Reserved)?;
            self.cubes.set_current(cx, Some(cube))?;
            let where_to = if goal.aside { ", out of the way" } else { "" };
            cx.world
                .out
                .log(format_args!("[acquire] {arm} -> {name}{where_to}"));
        }
        Ok(Status::Success)
    }

    fn is_free(&self, cx: &Context<'_, '_>, cube: usize) -> Result<bool, Fault> {
        let state = self.cubes.state(cx, cube)?;
        Ok(!matches!(state, CubeState::Reserved | CubeState::Carried))
    }

    /// The hand holds what another arm works at: that has to be let go of first,
    /// which a recovery does.
    fn is_others(&self, cx: &mut Context<'_, '_>) -> Result<bool, Fault> {
        let Some(held) = cx.world.cube_in_hand() else {
            return Ok(false);
        };
        if self.cubes.state(cx, held)? != CubeState::Others {
            return Ok(false);
        }
        let name = cx.world.setup.cube_name(held);
        self.recovery
            .request(cx, format_args!("{name} in the hand is another arm's"))?;
        Ok(true)
    }

    /// An arm that has nothing to do leaves the centre, and then its lock: the
    /// other one may be about to bring what this one waits for, or leave a cube
    /// alone because this hand is at it.
    fn rest(&self, state: &State, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        let Some(rest) = cx.world.rest() else {
            return Ok(());
        };
        cx.world.go(state.key, rest, GripperGoal::Keep);
        let there = cx
            .world
            .has_reached(state.key, &rest, AT_REST_M, AT_REST_RAD);
        if there {
            self.center.release(cx)?;
        }
        Ok(())
    }

    /// Gives up the reservation of another cube than `cube`.
    fn leave_other(&self, cx: &mut Context<'_, '_>, cube: usize) -> Result<(), Fault> {
        match self.cubes.current(cx)? {
            Some(other) if other != cube && !self.is_free(cx, other)? => {
                self.cubes.set_state(cx, other, CubeState::Available)
            }
            _ => Ok(()),
        }
    }
}

impl Leaf<PyramidHost> for AcquireCube {
    type State = State;

    fn start(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        state.key = cx.world.new_key();
        state.turn = Turn::default();
        state.waiting.clear();
        Ok(())
    }

    fn tick(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        if self.center.is_closed(cx)? {
            state.waiting.clear();
            state.turn.wait(state.key, cx);
            return Ok(Status::Running);
        }
        state.turn = Turn::default();
        if self.is_others(cx)? {
            return Ok(Status::Running);
        }
        let own = self.own(cx)?;
        if let Some(cube) = own {
            self.leave_other(cx, cube)?;
        }
        let stack = self.cubes.compare(cx)?;
        let cube = match own {
            Some(cube) => Some(cube),
            None => self.next(state, cx, stack)?,
        };
        if let Some(cube) = cube {
            state.last = Some(cube);
            return self.reserve(state, cx, cube, stack);
        }
        self.rest(state, cx)?;
        if state.waiting.is_due(cx.now, cx.get(&self.warning)?) {
            let arm = self.cubes.me();
            cx.world
                .out
                .log(format_args!("[warning] {arm}: no free cube within reach"));
        }
        Ok(Status::Running)
    }
}
