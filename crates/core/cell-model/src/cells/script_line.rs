//! The lines of a script: their actions and times.

use serde::{Deserialize, Serialize};

/// An action of a script.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum ScriptAction {
    /// Pull an object by a spring until it is within 5 mm or time is up.
    Drag {
        /// Name in the cell file.
        object: String,
        /// Where to, world frame (m).
        to: [f64; 3],
        /// For how long at most (s).
        #[serde(default = "two_seconds")]
        for_s: f64,
    },
    /// SIGTERM a process; it is started again.
    Restart {
        /// As for kill.
        process: String,
        /// Another policy, for the task.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        policy: Option<String>,
    },
    /// Eight busy loops beside the cell.
    Starve {
        /// How long (s, of the launcher's clock).
        for_s: f64,
    },
    /// Fills the file system of the run directory.
    Fill {
        /// As for starve.
        for_s: f64,
    },
    /// Overwrites bytes of a file with the memory of a process.
    Corrupt {
        /// One of [`CORRUPTIBLE`].
        file: String,
    },
    /// SIGKILL a process; it is started again.
    Kill {
        /// `task`, `physics`, `monitor`, `controller` or `controller-0`.
        process: String,
    },
    /// SIGSTOP a process for a while.
    Stop {
        /// As for kill.
        process: String,
        /// How long (s, of the launcher's clock).
        for_s: f64,
    },
    /// Operator's gripper button.
    Gripper {
        /// Which way.
        to: GripperWord,
        /// Arm by place in the cell file.
        #[serde(default)]
        arm: u32,
    },
    /// Operator's target.
    Target {
        /// TCP in the world frame (m).
        position: [f64; 3],
        /// Its orientation; if it is missing, that of the operator's last target, or that of
        /// the tool.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        orientation_wxyz: Option<[f64; 4]>,
        /// Arm by place in the cell file.
        #[serde(default)]
        arm: u32,
    },
    /// Asks for a bin.
    AddBin {
        /// Upside down; otherwise as the seed decides.
        #[serde(default)]
        flipped: bool,
    },
    /// Drops parts.
    DropParts {
        /// How many; 0: as many as the dispenser drops at a time.
        #[serde(default)]
        count: u32,
    },
    /// Start event of the task.
    TaskStart {},
    /// Pauses the task.
    TaskPause {},
    /// Resumes the task.
    TaskResume {},
    /// Resets the task to its start.
    TaskReset {},
    /// Pauses simulated time.
    Pause {
        /// How long (s, of the launcher's clock); if it is missing, until a person resumes it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        for_s: Option<f64>,
    },
    /// Resumes simulated time.
    Resume {},
    /// Resets the scene to its start.
    Reset {},
    /// Another speed of simulated time.
    Speed {
        /// Simulated seconds per second: 1 is real time, 0 as fast as possible.
        to: f64,
    },
    /// Pauses simulated time when the task reaches a node, state or guard.
    Break {
        /// Its name.
        name: String,
        /// Removes the breakpoint.
        #[serde(default)]
        remove: bool,
    },
}

/// Files of a run directory that a line may overwrite.
pub const CORRUPTIBLE: [&str; 3] = ["task.slots", "task.history", "physics.state"];

/// Open or close.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GripperWord {
    /// Open.
    Open,
    /// Close.
    Close,
}

fn two_seconds() -> f64 {
    2.0
}

fn one() -> u32 {
    1
}

impl ScriptAction {
    /// Whether the launcher has to act, because it concerns a process or the machine, or lasts
    /// for a time of its clock.
    pub fn is_for_launcher(&self) -> bool {
        match self {
            Self::Kill { .. }
            | Self::Stop { .. }
            | Self::Restart { .. }
            | Self::Starve { .. }
            | Self::Fill { .. }
            | Self::Corrupt { .. } => true,
            Self::Pause { for_s } => for_s.is_some(),
            _ => false,
        }
    }

    /// Whether it leads an arm, which only the operator may do while the task is paused.
    pub fn leads(&self) -> bool {
        matches!(self, Self::Gripper { .. } | Self::Target { .. })
    }

    /// Its name in a script.
    pub fn name(&self) -> String {
        // By serde, so that messages cannot name an action otherwise than a script does.
        let value = serde_json::to_value(self).unwrap_or_default();
        value["do"].as_str().unwrap_or_default().to_owned()
    }
}

/// The condition under which a line fires.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Trigger {
    /// At a simulated time.
    Time {
        /// Seconds of simulated time.
        at_s: f64,
    },
    /// On the nth entry into a phase, or some time after it.
    Phase {
        /// Name as the policy shows it.
        at_phase: String,
        /// Number of the entry, from 1.
        #[serde(default = "one")]
        nth: u32,
        /// Delay after the entry (s).
        #[serde(default)]
        after_s: f64,
    },
}

/// One line; a run file has its two parts separately.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScriptLine {
    /// When.
    pub trigger: Trigger,
    /// Its action.
    pub action: ScriptAction,
}
