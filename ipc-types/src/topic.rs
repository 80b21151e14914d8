//! The table of all topics: writer, readers, rate and depth.
//!
//! A topic has one writer process; what a reader misses is the oldest. A new topic needs a code
//! that was never used (recordings keep codes), a service name and a depth; the keeper creates
//! exactly the topics listed in `cell-bus/src/qos.rs`.

/// A topic of the cell, by number in [`crate::Input::topic`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TopicId {
    /// Physics to all, 1 kHz.
    WorldState,
    /// Physics to monitor, 50 Hz: pairs of bodies in contact, with forces.
    Contacts,
    /// Controller of an arm to physics, 1 kHz.
    ArmCommand(u8),
    /// Controller of an arm to all, 1 kHz.
    ArmStatus(u8),
    /// Task to controllers and physics, 100 Hz.
    Decision,
    /// Task to monitor, on change.
    Trace,
    /// A process to launcher and monitor, 100 Hz.
    Health(Process),
    /// Every state for the recorder, as [`crate::WorldPiece`]s.
    WorldTap,
    /// Every command for the recorder.
    ArmCommandTap(u8),
    /// Every status for the recorder.
    ArmStatusTap(u8),
    /// Every decision for the recorder.
    DecisionTap,
    /// Every input of the client of an arm for the recorder.
    ClientTap(u8),
    /// Checkpoints of a process, once a second, for the recorder.
    Keyframe(Process),
    /// Progress of the recorder, for physics: in lockstep it does not run ahead of what the
    /// taps can hold. A [`crate::Health`] whose header names the newest recorded state.
    Recorder,
}

/// A kind of process of the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Process {
    /// The robot and the world.
    Physics,
    /// The controller of one arm, by its place in the cell file.
    Controller(u8),
    /// The policy.
    Task,
    /// Page, recorder and operator requests.
    Monitor,
}

impl Process {
    /// `physics`, `controller-0`, `task`, `monitor`.
    pub fn name(self) -> String {
        match self {
            Self::Physics => "physics".to_owned(),
            Self::Controller(arm) => format!("controller-{arm}"),
            Self::Task => "task".to_owned(),
            Self::Monitor => "monitor".to_owned(),
        }
    }

    /// Number on the wire, within the topics of its kind.
    fn code(self) -> u32 {
        match self {
            Self::Physics => 0,
            Self::Task => 1,
            Self::Monitor => 2,
            Self::Controller(arm) => 0x10 + u32::from(arm),
        }
    }

    /// All processes of a cell of `arms` arms, in the order they are started.
    pub fn all(arms: u8) -> Vec<Self> {
        // Physics first: all others wait for its first state. The
        // monitor last: no process waits for it.
        let mut all = vec![Self::Physics];
        all.extend((0..arms).map(Self::Controller));
        all.extend([Self::Task, Self::Monitor]);
        all
    }
}

impl TopicId {
    /// Number on the wire, never 0.
    pub fn code(self) -> u32 {
        match self {
            // Codes are in the headers of recordings: a code is never given to another topic.
            Self::WorldState => 1,
            Self::Decision => 2,
            Self::Trace => 3,
            Self::ArmCommand(arm) => 0x100 + u32::from(arm),
            Self::ArmStatus(arm) => 0x200 + u32::from(arm),
            Self::Health(process) => 0x300 + process.code(),
            Self::WorldTap => 4,
            Self::DecisionTap => 5,
            Self::ArmCommandTap(arm) => 0x400 + u32::from(arm),
            Self::ArmStatusTap(arm) => 0x500 + u32::from(arm),
            Self::Keyframe(process) => 0x600 + process.code(),
            Self::ClientTap(arm) => 0x700 + u32::from(arm),
            Self::Recorder => 6,
            Self::Contacts => 7,
        }
    }

    /// Service name inside the run's own root and prefix.
    pub fn service(self) -> String {
        match self {
            Self::WorldState => "world/state".to_owned(),
            Self::Contacts => "world/contacts".to_owned(),
            Self::Decision => "task/decision".to_owned(),
            Self::Trace => "task/trace".to_owned(),
            Self::ArmCommand(arm) => format!("arm/{arm}/command"),
            Self::ArmStatus(arm) => format!("arm/{arm}/status"),
            Self::Health(process) => format!("health/{}", process.name()),
            Self::WorldTap => "tap/world".to_owned(),
            Self::ArmCommandTap(arm) => format!("tap/arm/{arm}/command"),
            Self::ArmStatusTap(arm) => format!("tap/arm/{arm}/status"),
            Self::DecisionTap => "tap/decision".to_owned(),
            Self::ClientTap(arm) => format!("tap/fci/{arm}"),
            Self::Keyframe(process) => format!("tap/keyframe/{}", process.name()),
            Self::Recorder => "recorder".to_owned(),
        }
    }

    /// Number of messages that a reader can be behind before the oldest is dropped. Control
    /// topics carry the newest value only. Of a status and of a decision two are kept: a reader
    /// working on tick k uses the one before it, and may look after that of tick k was sent
    /// (ADR 0004).
    pub fn depth(self) -> usize {
        match self {
            // A second of states, or a picture of the task of 1,000 lines.
            Self::Trace | Self::WorldTap => TRACE_DEPTH,
            Self::ArmStatus(_) | Self::Decision => 2,
            Self::ArmCommandTap(_) | Self::ArmStatusTap(_) => TAP_DEPTH,
            Self::DecisionTap => DECISION_TAP_DEPTH,
            Self::ClientTap(_) => CLIENT_TAP_DEPTH,
            Self::Keyframe(_) => KEYFRAME_DEPTH,
            _ => 1,
        }
    }

    /// The topic for copies of each message of this topic, as sent.
    pub fn tap(self) -> Option<Self> {
        // The state has none: its copies are pieces, which physics sends itself (ADR 0012).
        match self {
            Self::ArmCommand(arm) => Some(Self::ArmCommandTap(arm)),
            Self::ArmStatus(arm) => Some(Self::ArmStatusTap(arm)),
            Self::Decision => Some(Self::DecisionTap),
            _ => None,
        }
    }

    /// Whether only a recorder reads it.
    pub fn is_tap(self) -> bool {
        matches!(
            self,
            Self::WorldTap
                | Self::ArmCommandTap(_)
                | Self::ArmStatusTap(_)
                | Self::DecisionTap
                | Self::ClientTap(_)
                | Self::Keyframe(_)
        )
    }
}

/// Lines of the trace, and pieces of states for the recorder, that can wait.
// A picture of 100 nodes has 100 lines a second (ADR 0009),
// so a reader may be away for seconds.
pub const TRACE_DEPTH: usize = 1024;
/// Messages of an arm for the recorder that can wait: some 300 ms of lockstep at full
/// speed.
// Lockstep limits the run ahead as well, see `RECORDER_LAG_TICKS`.
pub const TAP_DEPTH: usize = 2048;
/// Decisions for the recorder that can wait: 2.5 s.
// In lockstep physics waits long before, see `RECORDER_LAG_TICKS`.
pub const DECISION_TAP_DEPTH: usize = 256;
/// Commands of clients for the recorder that can wait: half a second.
pub const CLIENT_TAP_DEPTH: usize = 512;
/// Parts of a checkpoint for the recorder that can wait.
// A task on a busy machine sends one with every decision.
pub const KEYFRAME_DEPTH: usize = 16;

/// Service name of the operator's requests.
pub const OPERATOR_SERVICE: &str = "operator";

/// Service name of the doorbell of a process that sleeps.
pub fn doorbell(process: Process) -> String {
    format!("bell/{}", process.name())
}
