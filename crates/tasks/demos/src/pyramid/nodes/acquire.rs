//! `AcquireCube`: takes the centre and reserves the next cube.

use std::sync::Arc;

use behavior::Status;
use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use behavior::value::Set;
use ipc_types::GripperGoal;
use robocell_skills::nodes::Context;
use robocell_skills::progress::Step;
use robocell_skills::shared::{Alarm, Turn};
use robocell_skills::world::Drive;
use robocell_skills::{Owner, Station};
use robocell_task::{PolicyTime, TraceEvent};
use serde::{Deserialize, Serialize};

use crate::pyramid::notes::Notes;
use crate::pyramid::setup::Pyramid;

/// An arm nearer than this to its rest pose is at rest (m).
const WAITS_M: f64 = 0.05;
/// And turned by less than this (rad).
const WAITS_RAD: f64 = 0.5;

/// See the module.
struct AcquireCube {
    warning: In<f64>,
    notes: Notes,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    step: Step,
    turn: Turn,
    waiting: Alarm,
    /// The cubes whose pose was unknown at the last attempt.
    unseen: Set,
    /// The cube that was reserved last; kept from one pick-up to the next.
    last: Option<usize>,
}

/// The node type.
pub(super) fn node_type(job: &Arc<Pyramid>) -> NodeType<Station> {
    let about = (
        "AcquireCube",
        "Waits until no other arm owns the centre, takes it, reserves the next \
         free cube of the arm's order, and computes the seven targets. A cube \
         that is the arm's already, or in its gripper, stays its cube. An arm whose \
         stack is whole takes cubes that another arm needs and cannot reach, and \
         fails without one.",
    );
    super::node_type(about, job, AcquireCube::new)
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
    fn new(notes: Notes, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let warning = binder.input("warning_interval")?;
        Ok(Self { warning, notes })
    }

    /// The cube that the arm already has: in its gripper, or reserved before.
    fn own(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        // The gripper first: a held cube has to be placed before another one can be picked.
        if let Some(held) = cx.world.held()
            && self.notes.owner(cx, held)? != Owner::Other
        {
            return Ok(Some(held));
        }
        match self.notes.current(cx)? {
            Some(current) if self.is_mine(cx, current)? => Ok(Some(current)),
            _ => Ok(None),
        }
    }

    fn is_mine(&self, cx: &Context<'_, '_>, cube: usize) -> Result<bool, Fault> {
        let owner = self.notes.owner(cx, cube)?;
        Ok(matches!(owner, Owner::Reserved | Owner::Carried))
    }

    /// The next cube: first one in the way of the stack, then those with room for the fingers,
    /// not the last one again, then those that only this arm reaches, then by
    /// the order. In an undisturbed pyramid the order alone decides. An arm whose stack is whole
    /// fetches only what another arm needs and cannot reach.
    fn next(
        &self,
        state: &State,
        cx: &Context<'_, '_>,
        stack: Set,
    ) -> Result<Option<usize>, Fault> {
        let look = self.notes.look(cx);
        let is_whole = look.is_whole();
        let mut best: Option<([bool; 4], usize)> = None;
        for cube in self.notes.order(cx.world.arm) {
            if self.notes.owner(cx, *cube)? != Owner::Available
                || (is_whole && !look.is_for_another(*cube))
            {
                continue;
            }
            let Some(position) = cx.world.position(*cube) else {
                if state.unseen.contains(self.notes.item(*cube)) {
                    continue;
                }
                // This cube is next in the order, but it is not observed: the caller reports
                // it, once.
                return Ok(Some(best.map_or(*cube, |(_, cube)| cube)));
            };
            if self.notes.is_given_up(cx, *cube, position)? {
                continue;
            }
            let ready = look.reaches(position)
                && !cx.world.is_covered(*cube)
                && !cx.world.is_held(*cube)
                && !look.is_at_another_gripper(position);
            let crowded = !look.is_free_around(*cube);
            // Compared as an array, first to last: `false` is better, so the order of the
            // entries is the order of the rules.
            let worse = [
                !look.is_in_the_way(stack, *cube),
                crowded,
                state.last == Some(*cube),
                cx.world.is_reached_by_another(position),
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
        let (arm, name) = (self.notes.me, cx.world.setup.object_name(cube));
        let Some(goal) = self.notes.aim(cx, cube, stack)? else {
            // Reported once for each cube, however often the node is tried.
            let item = self.notes.item(cube);
            if !state.unseen.contains(item) {
                state.unseen = state.unseen.with(item);
                let why = format_args!("[error] {arm}: the pose of {name} is not known");
                cx.world.out.event(TraceEvent::Fault, why);
            }
            return Ok(Status::Failure);
        };
        // All that can fail was computed above, so a node that fails leaves no lock and no
        // reservation behind.
        state.unseen = state.unseen.without(self.notes.item(cube));
        self.notes.recovery.clear(cx)?;
        self.notes.zone.take(cx)?;
        // The same cube is not reserved a second time: its log line would repeat in every
        // recovery.
        if self.notes.current(cx)? != Some(cube) || !self.is_mine(cx, cube)? {
            self.notes.set_owner(cx, cube, Owner::Reserved)?;
            self.notes.set_current(cx, Some(cube))?;
            let where_to = if goal.aside { ", out of the way" } else { "" };
            let out = &mut *cx.world.out;
            out.log(format_args!("[acquire] {arm} -> {name}{where_to}"));
        }
        Ok(Status::Success)
    }

    /// An arm without anything to do leaves the centre and releases it: the other arm may be
    /// about to bring a cube that this one waits for, or leave a cube alone because this
    /// gripper is near it.
    fn rest(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        let Some(arm) = cx.world.arm_setup() else {
            return Ok(());
        };
        let drive = Drive {
            tolerance_m: WAITS_M,
            angle_rad: WAITS_RAD,
            settle: PolicyTime::from_ticks(0),
            ..Drive::travel(arm.wait, GripperGoal::Keep)
        };
        // Released only once the arm is away: the other one would drive into it.
        if cx.world.drive(&mut state.step, &drive) {
            self.notes.zone.release(cx)?;
        }
        Ok(())
    }

    /// Without a cube to take: frees one below the stack, or waits out of the way.
    fn wait(
        &self,
        state: &mut State,
        cx: &mut Context<'_, '_>,
        stack: Set,
    ) -> Result<Status, Fault> {
        let look = self.notes.look(cx);
        if let Some(top) = look.top_over_obstacle(stack).filter(|_| !look.is_whole()) {
            let stack = self.notes.remove_from_stack(cx, top)?;
            return self.reserve(state, cx, top, stack);
        }
        let is_idle = look.is_whole() && !look.helps();
        if is_idle && !self.notes.zone.is_mine(cx)? {
            // Another arm has found a cube meanwhile: there is nothing left to do.
            return Ok(Status::Failure);
        }
        self.rest(state, cx)?;
        if is_idle {
            return Ok(Status::Running);
        }
        let since = state.step.began;
        cx.world
            .note_wait(since, format_args!("no free cube is in reach"));
        if state.waiting.is_due(cx.now, cx.get(&self.warning)?) {
            let arm = self.notes.me;
            let out = &mut *cx.world.out;
            out.log(format_args!("[warning] {arm}: no free cube within reach"));
            self.notes.try_again(cx)?;
        }
        Ok(Status::Running)
    }
}

impl Leaf<Station> for AcquireCube {
    type State = State;

    fn start(&self, state: &mut State, _cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        state.step = Step::default();
        state.turn = Turn::default();
        state.waiting.clear();
        Ok(())
    }

    fn tick(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        // Another arm owns the centre: nothing is read or written until it is free.
        if self.notes.zone.is_closed(cx)? {
            state.waiting.clear();
            state.step = Step::default();
            state.turn.wait_for(&self.notes.zone, cx)?;
            return Ok(Status::Running);
        }
        state.turn = Turn::default();
        // A cube of the other arm goes first: placing it on this stack would be counted in
        // neither.
        if let Some(held) = self.notes.held_of_another(cx)? {
            let name = cx.world.setup.object_name(held);
            let why = format_args!("{name} in the gripper is another arm's");
            self.notes.recovery.request(cx, why)?;
            return Ok(Status::Running);
        }
        let own = self.own(cx)?;
        // An arm works at one cube: the reservation of the former one would keep it from both
        // arms.
        if let (Some(cube), Some(other)) = (own, self.notes.current(cx)?)
            && other != cube
            && self.is_mine(cx, other)?
        {
            self.notes.set_owner(cx, other, Owner::Available)?;
        }
        // Before a choice the stack is compared with the observation, since people move cubes
        // at any time.
        let stack = self.notes.compare(cx)?;
        let cube = match own {
            Some(cube) => Some(cube),
            None => self.next(state, cx, stack)?,
        };
        if let Some(cube) = cube {
            state.last = Some(cube);
            return self.reserve(state, cx, cube, stack);
        }
        self.wait(state, cx, stack)
    }
}
