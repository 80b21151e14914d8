//! Endpoints of a cell on the network: streams, and commands.

use cell_model::Cell;
use ipc_types::GripperGoal;
use ipc_types::operator::OperatorAction;

use crate::ros::types::{self, RosType};

/// A message that is published repeatedly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stream {
    /// `/joint_states`.
    JointStates,
    /// `/tf`.
    Transforms,
    /// `/clock`.
    Clock,
    /// `/robocell/markers`.
    Markers,
    /// `/robocell/state`: JSON, for programs without ROS.
    State,
    /// `/robocell/events`: JSON lines of the task's trace.
    Events,
}

impl Stream {
    /// The streams with a rate.
    pub const ALL: [Self; 5] = [
        Self::JointStates,
        Self::Transforms,
        Self::Clock,
        Self::Markers,
        Self::State,
    ];

    /// Name of the stream on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::JointStates => "joint_states",
            Self::Transforms => "tf",
            Self::Clock => "clock",
            Self::Markers => "markers",
            Self::State => "state",
            Self::Events => "events",
        }
    }

    /// Rate by default (1/s).
    pub fn default_rate(self) -> f64 {
        match self {
            Self::JointStates | Self::Clock => 100.0,
            Self::Transforms => 30.0,
            Self::Markers => 5.0,
            Self::State => 10.0,
            Self::Events => 0.0,
        }
    }

    /// Name of its topic, within the namespace.
    pub fn topic(self) -> &'static str {
        match self {
            Self::JointStates => "/joint_states",
            Self::Transforms => "/tf",
            Self::Clock => "/clock",
            Self::Markers => "/robocell/markers",
            Self::State => "/robocell/state",
            Self::Events => "/robocell/events",
        }
    }

    /// Type of its messages.
    pub fn ros_type(self) -> RosType {
        match self {
            Self::JointStates => types::JOINT_STATE,
            Self::Transforms => types::TF_MESSAGE,
            Self::Clock => types::CLOCK,
            Self::Markers => types::MARKER_ARRAY,
            Self::State | Self::Events => types::STRING,
        }
    }
}

/// A command that a client with the token can send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Topic: move the tool of an arm to a pose.
    Target {
        /// By place in the cell file.
        arm: u32,
    },
    /// Service: open or close a gripper.
    Gripper {
        /// By place in the cell file.
        arm: u32,
        /// Goal of the gripper.
        goal: GripperGoal,
    },
    /// Service: start, pause, resume or reset the task.
    Task(OperatorAction),
}

/// A command and its name on the network, within the namespace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedCommand {
    /// `/target_pose`.
    pub name: String,
    /// The command.
    pub command: Command,
}

impl NamedCommand {
    /// Whether it is a service, not a topic.
    pub fn is_service(&self) -> bool {
        !matches!(self.command, Command::Target { .. })
    }

    /// Type of its messages.
    pub fn ros_type(&self) -> RosType {
        if self.is_service() {
            types::TRIGGER
        } else {
            types::POSE_STAMPED
        }
    }
}

/// All commands of a cell. With several arms, those of an arm start with its name.
pub fn commands(cell: &Cell) -> Vec<NamedCommand> {
    let task = [
        ("/task/start", OperatorAction::TaskStart),
        ("/task/pause", OperatorAction::TaskPause),
        ("/task/resume", OperatorAction::TaskResume),
        ("/task/reset", OperatorAction::TaskReset),
    ];
    let of_task = task.map(|(name, action)| NamedCommand {
        name: name.to_owned(),
        command: Command::Task(action),
    });
    let of_arms = (0..).zip(&cell.arms).flat_map(|(arm, spec)| {
        let prefix = arm_prefix(cell, &spec.name);
        let gripper = |goal| Command::Gripper { arm, goal };
        let all = [
            ("target_pose", Command::Target { arm }),
            ("gripper/open", gripper(GripperGoal::Open)),
            ("gripper/close", gripper(GripperGoal::Close)),
        ];
        all.map(|(name, command)| NamedCommand {
            name: format!("/{prefix}{name}"),
            command,
        })
    });
    of_task.into_iter().chain(of_arms).collect()
}

/// Prefix of the names of an arm: empty for a single arm.
pub fn arm_prefix(cell: &Cell, arm: &str) -> String {
    if cell.arms.len() < 2 {
        return String::new();
    }
    // Names of ROS allow nothing else.
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    format!("{}/", arm.chars().map(plain).collect::<String>())
}
