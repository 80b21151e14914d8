//! The parts of a tree that a host provides: leaves, and the world they act upon.

use std::time::Duration;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::board::{Board, Fault, In, Out, Scope, Slot};
use crate::status::{ResetReason, Status};
use crate::value::Plain;

/// Names the type of world a host lends to its leaves for one tick.
pub trait Host: 'static {
    /// The world, with all that it borrows.
    type World<'w>;
}

/// Whether a leaf that was told to stop has stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// It has stopped.
    Done,
    /// It needs another tick.
    NotYet,
}

/// An action or a condition. It is immutable: all it remembers is in its
/// `State`, so the checkpoint of a tree is complete (ADR 0008).
pub trait Leaf<H: Host>: Send + 'static {
    /// Its memory between ticks, also over several runs: reset it in
    /// [`Leaf::start`] where each run starts from the same state.
    type State: Default + Serialize + DeserializeOwned + Send;

    /// Called before the first tick of each run of the leaf.
    ///
    /// # Errors
    /// As [`Leaf::tick`].
    fn start(&self, state: &mut Self::State, cx: &mut Cx<'_, '_, H>) -> Result<(), Fault> {
        let _ = (state, cx);
        Ok(())
    }

    /// One tick of work.
    ///
    /// # Errors
    /// [`Fault`] of a port: the node fails, and the tree reports it.
    fn tick(&self, state: &mut Self::State, cx: &mut Cx<'_, '_, H>) -> Result<Status, Fault>;

    /// Called when it is stopped while running, and again in each tick until it
    /// returns `Done`; no other node of the tree runs in the meantime.
    fn halt(&self, state: &mut Self::State, cx: &mut Cx<'_, '_, H>, reason: ResetReason) -> Halt {
        let _ = (state, cx, reason);
        Halt::Done
    }

    /// Called each time the tree makes it invalid, also when it had finished
    /// before: where `py_trees` terminates a behaviour with INVALID. Few
    /// leaves need it; stopping work belongs into [`Leaf::halt`].
    fn invalidated(&self, state: &mut Self::State) {
        let _ = state;
    }
}

/// The context of a leaf during one call.
pub struct Cx<'a, 'w, H: Host> {
    /// Time of this tick; the same for all nodes of it.
    pub now: Duration,
    /// Time since the tick before; zero on the first.
    pub delta: Duration,
    /// Index of the node in the tree.
    pub node: usize,
    /// The host's world.
    pub world: &'a mut H::World<'w>,
    pub(crate) local: &'a mut Board,
    pub(crate) shared: &'a mut Board,
}

impl<H: Host> Cx<'_, '_, H> {
    /// Value of an input.
    ///
    /// # Errors
    /// [`Fault`] when its key has no value or one of another type.
    pub fn get<T: Plain>(&self, input: &In<T>) -> Result<T, Fault> {
        input.get(self.local, self.shared)
    }

    /// Value of an output's key.
    ///
    /// # Errors
    /// As [`Cx::get`].
    pub fn read<T: Plain>(&self, output: &Out<T>) -> Result<T, Fault> {
        output.slot.get(self.local, self.shared)
    }

    /// Writes an output.
    ///
    /// # Errors
    /// [`Fault::NotFinite`], and [`Fault::Access`] for a key that was registered
    /// for reading.
    pub fn set<T: Plain>(&mut self, output: &Out<T>, value: T) -> Result<(), Fault> {
        // The board does not know the writer, so the registered access is checked here.
        if !output.writable {
            return Err(Fault::Access);
        }
        let Slot { scope, index } = output.slot;
        let value = value.into_value();
        if self.board(scope).set(index, value) {
            Ok(())
        } else {
            Err(Fault::NotFinite(output.slot))
        }
    }

    /// Removes the value of an output's key, if it may be written.
    pub fn unset<T: Plain>(&mut self, output: &Out<T>) {
        let Slot { scope, index } = output.slot;
        if output.writable {
            self.board(scope).unset(index);
        }
    }

    /// Whether an output's key has a value.
    pub fn is_set<T: Plain>(&self, output: &Out<T>) -> bool {
        let Slot { scope, index } = output.slot;
        match scope {
            Scope::Local => self.local.value(index).is_some(),
            Scope::Shared => self.shared.value(index).is_some(),
        }
    }

    /// The board of a scope, for a [`crate::board::Client`].
    pub fn board(&mut self, scope: Scope) -> &mut Board {
        match scope {
            Scope::Local => self.local,
            Scope::Shared => self.shared,
        }
    }
}

/// A [`Leaf`] with its state, of any type.
pub trait AnyLeaf<H: Host>: Send {
    /// [`Leaf::tick`], after [`Leaf::start`] if a run starts with it.
    ///
    /// # Errors
    /// As there.
    fn tick(&mut self, begins: bool, cx: &mut Cx<'_, '_, H>) -> Result<Status, Fault>;

    /// See [`Leaf::halt`].
    fn halt(&mut self, cx: &mut Cx<'_, '_, H>, reason: ResetReason) -> Halt;

    /// See [`Leaf::invalidated`].
    fn invalidated(&mut self);

    /// Appends the state as plain bytes.
    fn save(&self, record: &mut Vec<u8>);

    /// Restores the state; `false`, and no change, for bytes of another type.
    fn restore(&mut self, bytes: &[u8]) -> bool;

    /// The state of a leaf that never ran.
    fn forget(&mut self);
}

/// Makes any leaf an [`AnyLeaf`].
pub fn any<H: Host, L: Leaf<H>>(leaf: L) -> Box<dyn AnyLeaf<H>> {
    Box::new(WithState {
        leaf,
        state: L::State::default(),
    })
}

struct WithState<L, S> {
    leaf: L,
    state: S,
}

impl<H: Host, L: Leaf<H>> AnyLeaf<H> for WithState<L, L::State> {
    fn tick(&mut self, begins: bool, cx: &mut Cx<'_, '_, H>) -> Result<Status, Fault> {
        if begins {
            self.leaf.start(&mut self.state, cx)?;
        }
        self.leaf.tick(&mut self.state, cx)
    }

    fn halt(&mut self, cx: &mut Cx<'_, '_, H>, reason: ResetReason) -> Halt {
        self.leaf.halt(&mut self.state, cx, reason)
    }

    fn invalidated(&mut self) {
        self.leaf.invalidated(&mut self.state);
    }

    fn save(&self, record: &mut Vec<u8>) {
        // Writing plain data to memory does not fail.
        let _written = bincode::serialize_into(record, &self.state).is_ok();
    }

    fn restore(&mut self, bytes: &[u8]) -> bool {
        let Ok(state) = bincode::deserialize::<L::State>(bytes) else {
            // The leaf keeps the state of one that never ran; the tree counts it as lost.
            return false;
        };
        // A shorter state of another type could be read from longer bytes, too.
        let whole = bincode::serialized_size(&state).ok() == u64::try_from(bytes.len()).ok();
        if whole {
            self.state = state;
        }
        whole
    }

    fn forget(&mut self) {
        self.state = L::State::default();
    }
}
