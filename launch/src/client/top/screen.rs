//! What `top` shows, wherever it comes from.

use crate::client::status::ProcessStatus;

/// All texts of a frame.
#[derive(Debug, Default)]
pub(super) struct Screen {
    /// Demo, cell and time.
    pub(super) title: String,
    /// How the task is doing.
    pub(super) task: String,
    /// The nodes or states at work, by picture of the policy.
    pub(super) active: Vec<String>,
    pub(super) processes: Vec<ProcessStatus>,
    /// Lines of all arms.
    pub(super) arms: Vec<String>,
    /// A line for each device; nothing in a cell without equipment.
    pub(super) equipment: Vec<String>,
    /// What the task said: simulated seconds and text, the oldest first.
    pub(super) log: Vec<(f64, String)>,
}

/// An arm in four lines.
pub(super) struct ArmText<'a> {
    pub(super) index: usize,
    /// rad or m.
    pub(super) joint_positions: &'a [f64],
    /// N·m or N.
    pub(super) joint_efforts: &'a [f64],
    /// World frame (m).
    pub(super) tcp: [f64; 3],
    /// What is said after its position.
    pub(super) more: String,
    pub(super) gripper: String,
}

impl ArmText<'_> {
    pub(super) fn lines(&self) -> [String; 4] {
        let list = |values: &[f64]| {
            let texts: Vec<_> = values.iter().map(|v| format!("{v:>8.3}")).collect();
            texts.concat()
        };
        let ([x, y, z], index, more) = (self.tcp, self.index, &self.more);
        [
            format!("{index} joints rad  {}", list(self.joint_positions)),
            format!("  efforts     {}", list(self.joint_efforts)),
            format!("  tcp {x:.3} {y:.3} {z:.3} m{more}"),
            format!("  {}", self.gripper),
        ]
    }
}
