//! Events and actions: input and output of the supervisor.

use ipc_types::topic::Process;

/// How strict the supervisor is.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Whether a process that seems to hang is killed.
    pub watchdog: bool,
    /// Whether physics waits for every process: then one that waits does not hang.
    pub lockstep: bool,
    /// Whether the task is a Python file, whose imports take time at every start.
    pub python_task: bool,
}

/// How a process ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// By itself, with this exit code.
    Code(i32),
    /// By this signal.
    Signal(i32),
}

/// Something happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// A health message arrived.
    Health {
        /// The sender.
        process: Process,
        /// Which start of it.
        generation: u32,
        /// Its count of cycles.
        cycles: u64,
        /// Whether it has real-time scheduling.
        fifo: bool,
    },
    /// Time in which messages of the processes were received since the last such event. A
    /// process without a message was silent for all of it.
    Listened {
        /// Nanoseconds.
        ns: u64,
    },
    /// A process could do nothing for so long since the last time, because it got no
    /// core, disk or page.
    Starved {
        /// Which.
        process: Process,
        /// Which start of it.
        generation: u32,
        /// Nanoseconds.
        ns: u64,
    },
    /// A process was killed or exits, and its last threads wait for a core to end.
    Dying {
        /// Which.
        process: Process,
        /// Which start of it.
        generation: u32,
    },
    /// A process is gone.
    Exited {
        /// Which.
        process: Process,
        /// Which start of it.
        generation: u32,
        /// How.
        exit: Exit,
    },
    /// A process could not even be started.
    SpawnFailed {
        /// Which.
        process: Process,
        /// Which start of it.
        generation: u32,
        /// Why, in words.
        why: String,
    },
    /// A request for an orderly restart.
    Restart {
        /// Of which process.
        process: Process,
    },
    /// A request for SIGKILL and a new start.
    KillAndRestart {
        /// Of which process.
        process: Process,
    },
    /// Whether there is room for a process to start, in memory and in the run directory.
    Room(bool),
    /// The launcher's own ports hear nothing any more.
    BusLost,
    /// Stop everything in order.
    Stop,
    /// Kill everything at once.
    Abort,
}

/// Something has to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Start `process` as its start number `generation`.
    Spawn {
        /// Which.
        process: Process,
        /// From 1 up.
        generation: u32,
    },
    /// The shared memory of the bus is given up: all processes end, and start again on a
    /// new bus, once in a run.
    LeaveBus {
        /// Why, in words.
        reason: String,
    },
    /// No process runs: the new bus is made now, and starts follow.
    NewBus,
    /// Ask it to end (SIGTERM).
    Terminate {
        /// Which.
        process: Process,
    },
    /// End it (SIGKILL).
    Kill {
        /// Which.
        process: Process,
    },
    /// Every process has shown itself for the first time.
    Ready,
    /// It died or hung and comes back; say so.
    Lost {
        /// Which.
        process: Process,
        /// What happened, in words.
        what: String,
    },
    /// It gets so little of the processor that it would count as hung; say so. It is
    /// left running.
    Starves {
        /// Which.
        process: Process,
        /// Time it could do nothing (ns).
        starved_ns: u64,
        /// Of how long without a sign of life (ns).
        silent_ns: u64,
    },
    /// It is not started again; a monitor is, after a long delay.
    GaveUp {
        /// Which.
        process: Process,
        /// Why, in words.
        reason: String,
        /// It never worked, and reported that its inputs cannot be used.
        refused: bool,
    },
}
