//! What saving needs of the place of the states: files and a thread, or a model of both.

use std::io;

/// Keeps the newest two states, and writes one at a time.
pub trait Store {
    /// The newest state; `None` if there is none.
    ///
    /// # Errors
    /// The damage, or those of the file system.
    fn read(&self) -> io::Result<Option<Vec<u8>>>;

    /// The state before the newest, as [`Self::read`].
    fn read_older(&self) -> io::Result<Option<Vec<u8>>>;

    /// Replaces the newest state, which is damaged, by the one before.
    ///
    /// # Errors
    /// Those of the file system.
    fn replace_by_older(&self) -> io::Result<()>;

    /// Its name, for messages.
    fn name(&self) -> String;

    /// Whether another state can be handed over.
    fn is_idle(&self) -> bool;

    /// Hands over the state of `tick` that `fill` appends to an empty buffer.
    fn write(&mut self, tick: u64, fill: impl FnOnce(&mut Vec<u8>));

    /// The result of a write since the last call. Never waits: this is called between two
    /// ticks.
    fn result(&mut self) -> Option<(u64, Result<(), String>)>;

    /// Waits until the running write has a result.
    fn wait(&mut self);
}
