//! What the supervisor's loop needs of the operating system and of the bus.

use cell_model::cells::script::ScriptAction;
use cell_rt::process::Share;
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;

use super::watch::{News, Watch};
use crate::failure::Failure;
use crate::supervision::Exit;

/// The threads of a process: the main thread, and the others by id where they were asked for.
pub type Threads = (Share, Vec<(u32, Share)>);

/// The processes of a cell, their bus, and what a person is told.
///
/// A running cell has children of the launcher and shared memory behind it, a simulated
/// cell has models of both. Nothing here waits.
pub trait Machine {
    /// Starts `process` as its start number `generation`; the error is in words.
    fn spawn(&mut self, process: Process, generation: u32) -> Result<(), String>;

    /// Asks `process` to end, also one that is stopped.
    fn terminate(&mut self, process: Process);

    /// Ends `process`.
    fn kill(&mut self, process: Process);

    /// Stops `process` where it is.
    fn freeze(&mut self, process: Process);

    /// Continues a stopped `process`.
    fn thaw(&mut self, process: Process);

    /// The next start of the task has this policy; the error is in words.
    fn choose(&mut self, policy: &str) -> Result<(), String>;

    /// Does what a line of a script says about the machine; the error is in words.
    fn disturb(&mut self, now_ns: u64, action: &ScriptAction) -> Result<(), String>;

    /// Ends the disturbances whose time is over.
    fn end_disturbances(&mut self, now_ns: u64);

    /// The processes that ended since the last call: which start of them, and how.
    fn reap(&mut self) -> Vec<(Process, u32, Exit)>;

    /// Process id of `process`, while it exists.
    fn pid(&self, process: Process) -> Option<u32>;

    /// What the threads of the process `pid` did so far; without the others of it unless
    /// `all`.
    fn threads(&self, pid: u32, all: bool) -> Option<Threads>;

    /// What a start of a process lacks, in words; `None` where there is room.
    fn lack_of_room(&self) -> Option<String>;

    /// Removes what a killed process left half-made on the bus. `ended`: a process ended
    /// since the last call; `silence_ns`: of the most silent process.
    fn remove_half_made(&mut self, now_ns: u64, ended: bool, silence_ns: u64);

    /// Takes the messages that the bus delivered since the last call.
    fn news(&mut self, now_ns: u64) -> News;

    /// For how long the launcher has not received on the bus (ns).
    fn deaf_ns(&self, now_ns: u64) -> u64;

    /// Requests something of physics; the answer is in the news. A request made while
    /// another is in flight is dropped, and is made again by the caller that needs it.
    fn ask(&mut self, action: OperatorAction, count: u32);

    /// Replaces the bus. No process runs.
    fn new_bus(&mut self) -> Result<(), Failure>;

    /// Takes note of what the processes reported until now, for incidents.
    fn note(&mut self, now_ns: u64, watch: &Watch);

    /// Keeps an incident: `process` failed, in words. Returns how a person looks at it.
    fn incident(&mut self, now_ns: u64, process: Process, what: &str) -> String;

    /// The last `count` lines that `process` wrote.
    fn last_words(&self, process: Process, count: usize) -> Vec<String>;

    /// Tells the person.
    fn warn(&mut self, text: &str);
}
