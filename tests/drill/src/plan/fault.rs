//! What can go wrong.

use serde::{Deserialize, Serialize};

/// A cause of failure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum Fault {
    /// SIGKILL; with `effect` in its next turn, after so many effects of that turn.
    Kill {
        /// Its name.
        process: String,
        /// See [`cell_rt::Effects`].
        #[serde(default, skip_serializing_if = "Option::is_none")]
        effect: Option<u64>,
    },
    /// SIGSTOP for some time.
    Stop {
        /// Its name.
        process: String,
        /// How long.
        for_ms: u64,
    },
    /// It gets no core for some time.
    Starve {
        /// Its name.
        process: String,
        /// How long.
        for_ms: u64,
    },
    /// Each of its turns takes longer for some time, as on a core that it shares with many.
    Busy {
        /// Its name.
        process: String,
        /// How long.
        for_ms: u64,
        /// Time of a turn (us).
        turn_us: u64,
    },
    /// It runs in a circle: it has a core, and no turn of it ends.
    Hang {
        /// Its name.
        process: String,
    },
    /// A person restarts it.
    Restart {
        /// Its name.
        process: String,
    },
    /// No room in shared memory, and no write to the disk succeeds.
    Full {
        /// How long.
        for_ms: u64,
    },
    /// Writes of states of physics take longer.
    SlowDisk {
        /// How long this lasts.
        for_ms: u64,
        /// Time of one write.
        write_ms: u64,
    },
    /// The next start of a process ends with exit code 1.
    FailedStart {
        /// Its name.
        process: String,
    },
    /// The next start of a process takes longer.
    SlowStart {
        /// Its name.
        process: String,
        /// How long it takes.
        for_ms: u64,
    },
    /// The launcher is not scheduled.
    Launcher {
        /// How long.
        for_ms: u64,
    },
    /// A bit of a file is flipped.
    DamageFile {
        /// One of [`Fault::FILES`]; the next one that has a record, if it has none.
        file: String,
        /// Chooses the bit.
        draw: u64,
    },
    /// SIGKILL of physics when its writer has done so many steps of the next state: a file is made,
    /// gets a head and a content, and two files are renamed.
    CutWrite {
        /// How many.
        steps: u64,
    },
    /// A bit of the next message of a topic is flipped, so that its readers can tell.
    Damage {
        /// See [`super::topic`].
        topic: String,
        /// Chooses the bit.
        draw: u64,
    },
    /// The next messages of a topic come twice.
    Repeat {
        /// See [`super::topic`].
        topic: String,
        /// Newer messages before each comes again; with 0 it comes when its reader has taken it.
        after: u32,
        /// How many messages.
        #[serde(default = "one")]
        count: u32,
    },
    /// The next message of a topic comes after newer ones.
    Late {
        /// See [`super::topic`].
        topic: String,
        /// Newer messages before it.
        after: u32,
    },
    /// It loses its core within each turn, between two of its messages, rings and replies.
    Preempt {
        /// Its name.
        process: String,
        /// How long.
        for_ms: u64,
        /// For how long it has no core each time.
        gap_us: u64,
    },
}

fn one() -> u32 {
    1
}

impl Fault {
    /// Names of all kinds.
    pub const KINDS: [&str; 17] = [
        "kill",
        "stop",
        "starve",
        "full",
        "slow_disk",
        "failed_start",
        "slow_start",
        "launcher",
        "busy",
        "hang",
        "restart",
        "damage_file",
        "cut_write",
        "damage",
        "repeat",
        "late",
        "preempt",
    ];

    /// Files that a successor reads.
    pub const FILES: [&str; 4] = [
        "physics.state",
        "physics.requests",
        "task.slots",
        "task.history",
    ];

    /// The process that it is about.
    pub fn process(&self) -> Option<&str> {
        match self {
            Self::Kill { process, .. }
            | Self::Stop { process, .. }
            | Self::Starve { process, .. }
            | Self::Busy { process, .. }
            | Self::Hang { process }
            | Self::Restart { process }
            | Self::FailedStart { process }
            | Self::Preempt { process, .. }
            | Self::SlowStart { process, .. } => Some(process),
            Self::Full { .. }
            | Self::SlowDisk { .. }
            | Self::DamageFile { .. }
            | Self::CutWrite { .. }
            | Self::Damage { .. }
            | Self::Repeat { .. }
            | Self::Late { .. }
            | Self::Launcher { .. } => None,
        }
    }

    /// How long it lasts (ms).
    pub fn length_ms(&self) -> u64 {
        match self {
            Self::Kill { .. }
            | Self::FailedStart { .. }
            | Self::Hang { .. }
            | Self::DamageFile { .. }
            | Self::CutWrite { .. }
            | Self::Damage { .. }
            | Self::Repeat { .. }
            | Self::Late { .. }
            | Self::Restart { .. } => 0,
            Self::Stop { for_ms, .. }
            | Self::Starve { for_ms, .. }
            | Self::Full { for_ms }
            | Self::SlowDisk { for_ms, .. }
            | Self::SlowStart { for_ms, .. }
            | Self::Busy { for_ms, .. }
            | Self::Preempt { for_ms, .. }
            | Self::Launcher { for_ms } => *for_ms,
        }
    }

    /// Place of its kind in [`Self::KINDS`].
    pub fn kind(&self) -> usize {
        match self {
            Self::Kill { .. } => 0,
            Self::Stop { .. } => 1,
            Self::Starve { .. } => 2,
            Self::Full { .. } => 3,
            Self::SlowDisk { .. } => 4,
            Self::FailedStart { .. } => 5,
            Self::SlowStart { .. } => 6,
            Self::Launcher { .. } => 7,
            Self::Busy { .. } => 8,
            Self::Hang { .. } => 9,
            Self::Restart { .. } => 10,
            Self::DamageFile { .. } => 11,
            Self::CutWrite { .. } => 12,
            Self::Damage { .. } => 13,
            Self::Repeat { .. } => 14,
            Self::Late { .. } => 15,
            Self::Preempt { .. } => 16,
        }
    }
}
