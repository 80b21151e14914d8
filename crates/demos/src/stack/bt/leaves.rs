//! Conditions and actions of the stacking tree.

use behavior::Status;
use behavior::board::Fault;
use behavior::tree::{BindError, Cx, Leaf};
use ipc_types::GripperGoal;

use super::keys::{HOLDING, Keys, PICK_TARGET, Reads, Writes};
use super::world::StackHost;
use crate::stack::recovery;
use crate::stack::selection::{self, Selection};

type Call<'a, 'w> = Cx<'a, 'w, StackHost>;
type Name = behavior::Str;

fn answer(holds: bool) -> Status {
    if holds {
        Status::Success
    } else {
        Status::Failure
    }
}

/// Nothing is under way and every cube is at its goal.
pub struct AllStacked {
    pick_target: Reads<Name>,
    holding: Reads<Name>,
}

impl AllStacked {
    /// # Errors
    /// [`BindError`] where a key was not declared.
    pub fn new(mut keys: Keys<'_>) -> Result<Self, BindError> {
        Ok(Self {
            pick_target: keys.cube(PICK_TARGET)?,
            holding: keys.cube(HOLDING)?,
        })
    }
}

impl Leaf<StackHost> for AllStacked {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        if self.pick_target.cube(cx)?.is_some() || self.holding.cube(cx)?.is_some() {
            return Ok(Status::Failure);
        }
        let world = &mut *cx.world;
        let all = selection::select(world.setup, world.scene, world.job) == Selection::AllPlaced;
        selection::note_all_placed(all, world.job, world.out);
        Ok(answer(all))
    }
}

/// The cube that ought to be in the gripper is not.
pub struct CubeDropped(Reads<Name>);

impl CubeDropped {
    /// # Errors
    /// [`BindError`] where a key was not declared.
    pub fn new(mut keys: Keys<'_>) -> Result<Self, BindError> {
        Ok(Self(keys.cube(HOLDING)?))
    }
}

impl Leaf<StackHost> for CubeDropped {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        let (setup, scene) = (cx.world.setup, cx.world.scene);
        let held = self.0.cube(cx)?;
        Ok(answer(
            held.is_some_and(|cube| recovery::dropped(setup, scene, cube)),
        ))
    }
}

/// The held cube cannot go where it was going: a lower one is not in place, or
/// another one stands there. A cube that is only moved out of the way has no
/// place in the stack at all.
pub struct StackBelowBroken(Reads<Name>);

impl StackBelowBroken {
    /// # Errors
    /// [`BindError`] where a key was not declared.
    pub fn new(mut keys: Keys<'_>) -> Result<Self, BindError> {
        Ok(Self(keys.cube(HOLDING)?))
    }
}

impl Leaf<StackHost> for StackBelowBroken {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        let (setup, scene) = (cx.world.setup, cx.world.scene);
        let held = self.0.cube(cx)?;
        let aborted = cx.world.job.aborted;
        Ok(answer(held.is_some_and(|cube| {
            aborted || selection::destination_lost(setup, scene, cube)
        })))
    }
}

/// Chooses the next cube; runs while there is none within reach.
pub struct SelectNextCube {
    pick_target: Writes<Name>,
    holding: Reads<Name>,
    pickup: Writes<[f64; 4]>,
}

impl SelectNextCube {
    /// # Errors
    /// [`BindError`] where a key was not declared.
    pub fn new(mut keys: Keys<'_>) -> Result<Self, BindError> {
        Ok(Self {
            pick_target: keys.cube_to_write(PICK_TARGET)?,
            holding: keys.cube(HOLDING)?,
            pickup: keys.place_to_write()?,
        })
    }
}

impl Leaf<StackHost> for SelectNextCube {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        if self.holding.cube(cx)?.is_some() {
            return Ok(Status::Success);
        }
        self.pickup.remember(cx, None)?;
        let world = &mut *cx.world;
        let (setup, scene, now) = (world.setup, world.scene, world.now);
        let next = selection::decide(setup, scene, now, "select", world.job, world.out);
        let Some(next) = next else {
            self.pick_target.name(cx, None)?;
            return Ok(Status::Running);
        };
        world.job.destination = Some(next.destination);
        world.job.aborted = next.clears;
        self.pick_target.name(cx, Some(next.cube))?;
        Ok(Status::Success)
    }
}

/// The cube that was picked up is in the gripper from here on.
pub struct MarkHolding {
    pick_target: Reads<Name>,
    holding: Writes<Name>,
}

impl MarkHolding {
    /// # Errors
    /// [`BindError`] where a key was not declared.
    pub fn new(mut keys: Keys<'_>) -> Result<Self, BindError> {
        Ok(Self {
            pick_target: keys.cube(PICK_TARGET)?,
            holding: keys.cube_to_write(HOLDING)?,
        })
    }
}

impl Leaf<StackHost> for MarkHolding {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        let cube = self.pick_target.cube(cx)?;
        self.holding.name(cx, cube)?;
        let object = cube.and_then(|c| cx.world.setup.cube(c)).map(|c| c.object);
        cx.world.job.held = object;
        Ok(answer(cube.is_some()))
    }
}

/// The transfer is over: nothing is held and nothing is being picked up. After
/// a drop the decision is emptied besides, and the gripper opens.
pub struct ClearHolding {
    pick_target: Writes<Name>,
    holding: Writes<Name>,
    pickup: Writes<[f64; 4]>,
    dropped: bool,
}

impl ClearHolding {
    /// After a place.
    ///
    /// # Errors
    /// [`BindError`] where a key was not declared.
    pub fn new(mut keys: Keys<'_>) -> Result<Self, BindError> {
        Ok(Self {
            pick_target: keys.cube_to_write(PICK_TARGET)?,
            holding: keys.cube_to_write(HOLDING)?,
            pickup: keys.place_to_write()?,
            dropped: false,
        })
    }

    /// After a drop.
    ///
    /// # Errors
    /// [`BindError`] where a key was not declared.
    pub fn dropped(keys: Keys<'_>) -> Result<Self, BindError> {
        Ok(Self {
            dropped: true,
            ..Self::new(keys)?
        })
    }
}

impl Leaf<StackHost> for ClearHolding {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Call<'_, '_>) -> Result<Status, Fault> {
        if let Some(cube) = self.holding.cube(cx)?.filter(|_| self.dropped) {
            let world = &mut *cx.world;
            recovery::note_drop(world.setup, cube, world.job, world.out);
            world.intent = None;
            world.gripper = GripperGoal::Open;
        }
        self.holding.name(cx, None)?;
        self.pick_target.name(cx, None)?;
        self.pickup.remember(cx, None)?;
        recovery::forget_held(cx.world.job);
        Ok(Status::Success)
    }
}
