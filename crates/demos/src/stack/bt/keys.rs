//! The three blackboard keys of the tree.

use behavior::board::{Access, Board, BoardError, Fault, In, Out};
use behavior::tree::{BindError, Binder, Cx};
use behavior::{Str, board::Scope};

use super::world::StackHost;
use crate::stack::StackSetup;
use robocell_task::job::Placement;

/// Name of the cube that is being picked up, empty for none.
pub const PICK_TARGET: &str = "pick_target";
/// Name of the cube in the gripper, empty for none.
pub const HOLDING: &str = "holding";
/// Where it was gripped: x, y, z (m) and the turn of the tool (rad).
pub const PICKUP_POSITION: &str = "pickup_position";

type Call<'a, 'w> = Cx<'a, 'w, StackHost>;

/// A key that is only read.
pub struct Reads<T>(In<T>);
/// A key that is written.
pub struct Writes<T>(Out<T>);

/// Hands out keys to the leaf `node`, registering each access.
pub struct Keys<'b> {
    binder: Binder<'b>,
}

impl<'b> Keys<'b> {
    /// Keys of `board` for the leaf `node`.
    pub fn new(binder: Binder<'b>) -> Self {
        Self { binder }
    }

    /// To read a cube's name.
    ///
    /// # Errors
    /// [`BindError`] where the key was not declared.
    pub fn cube(&mut self, key: &str) -> Result<Reads<Str>, BindError> {
        Ok(Reads(self.binder.reads(Scope::Local, key)?))
    }

    /// To write a cube's name.
    ///
    /// # Errors
    /// As [`Keys::cube`].
    pub fn cube_to_write(&mut self, key: &str) -> Result<Writes<Str>, BindError> {
        let access = Access::Write;
        Ok(Writes(self.binder.writes(
            Scope::Local,
            key,
            None,
            access,
        )?))
    }

    /// To write where a cube was gripped.
    ///
    /// # Errors
    /// As [`Keys::cube`].
    pub fn place_to_write(&mut self) -> Result<Writes<[f64; 4]>, BindError> {
        let (scope, access) = (Scope::Local, Access::Write);
        let key = self.binder.writes(scope, PICKUP_POSITION, None, access)?;
        Ok(Writes(key))
    }

    /// To read where a cube was gripped.
    ///
    /// # Errors
    /// As [`Keys::cube`].
    pub fn place(&mut self) -> Result<Reads<[f64; 4]>, BindError> {
        Ok(Reads(self.binder.reads(Scope::Local, PICKUP_POSITION)?))
    }
}

/// A board with the three keys.
///
/// # Errors
/// [`BoardError`], which a fresh board has no reason for.
pub fn board() -> Result<Board, BoardError> {
    use behavior::{Value, ValueType};
    let mut board = Board::new();
    for name in [PICK_TARGET, HOLDING] {
        board.declare(name, ValueType::Text, Some(Value::Text(Str::EMPTY)))?;
    }
    board.declare(PICKUP_POSITION, ValueType::Numbers, None)?;
    Ok(board)
}

impl Reads<Str> {
    /// Placement in the order of the named cube.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn cube(&self, cx: &Call<'_, '_>) -> Result<Option<usize>, Fault> {
        let name = cx.get(&self.0)?;
        Ok(find(cx.world.setup, &name))
    }
}

impl Writes<Str> {
    /// As [`Reads::cube`].
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn cube(&self, cx: &Call<'_, '_>) -> Result<Option<usize>, Fault> {
        let name = cx.read(&self.0)?;
        Ok(find(cx.world.setup, &name))
    }

    /// Names a cube, or none.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn name(&self, cx: &mut Call<'_, '_>, cube: Option<usize>) -> Result<(), Fault> {
        let name = cube.map_or("", |c| cx.world.setup.name(c));
        let name = Str::new(name).ok_or(Fault::Node("a cube's name is too long"))?;
        cx.set(&self.0, name)
    }
}

impl Reads<[f64; 4]> {
    /// Where the cube was gripped, `None` before.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn place(&self, cx: &Call<'_, '_>) -> Result<Option<Placement>, Fault> {
        match cx.get(&self.0) {
            Ok(numbers) => Ok(Some(place(numbers))),
            Err(Fault::Unset(_)) => Ok(None),
            Err(fault) => Err(fault),
        }
    }
}

impl Writes<[f64; 4]> {
    /// As [`Reads::place`].
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn place(&self, cx: &Call<'_, '_>) -> Result<Option<Placement>, Fault> {
        match cx.read(&self.0) {
            Ok(numbers) => Ok(Some(place(numbers))),
            Err(Fault::Unset(_)) => Ok(None),
            Err(fault) => Err(fault),
        }
    }

    /// Remembers where the cube was gripped, or forgets it.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn remember(&self, cx: &mut Call<'_, '_>, place: Option<Placement>) -> Result<(), Fault> {
        let Some(Placement { position, yaw }) = place else {
            cx.unset(&self.0);
            return Ok(());
        };
        let [x, y, z] = position;
        cx.set(&self.0, [x, y, z, yaw])
    }
}

fn find(setup: &StackSetup, name: &Str) -> Option<usize> {
    let name = name.as_str();
    setup.cubes.iter().position(|c| c.name == name)
}

/// The place written in the key.
pub fn place([x, y, z, yaw]: [f64; 4]) -> Placement {
    Placement {
        position: [x, y, z],
        yaw,
    }
}
