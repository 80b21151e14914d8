//! Kinds that have a word on the command line.

use clap::ValueEnum;

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum FaultKind {
    /// SIGKILL of a process
    Kill,
    /// SIGSTOP of a process, and SIGCONT after up to 2.5 s
    Stop,
    /// Eight busy loops for 3 s
    Starve,
    /// Connections and nonsense at the control socket for 3 s
    Flood,
    /// No room in the run directory's file system for 3 s
    Fill,
    /// Random bytes in a file a successor reads, and SIGKILL of its owner
    Corrupt,
}

/// Names that depend on the files and on the running cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NameKind {
    /// Cell files.
    Demos,
    /// Policies of the demo on the command line, or of the cell that runs.
    Policies,
    /// Objects of the cell that runs.
    Objects,
    /// Nodes and states of the policy that runs.
    Nodes,
    /// Cells that run.
    Cells,
    /// Processes of the cell that runs.
    Processes,
}

/// A command with `--json`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OutputName {
    /// `bench`.
    Bench,
    /// `chaos`.
    Chaos,
    /// `bt check` and `fsm check`.
    Check,
    /// `doctor`.
    Doctor,
    /// `eval`: each line.
    Eval,
    /// `grasp`.
    Grasp,
    /// `incident N`.
    Incident,
    /// `incident`.
    Incidents,
    /// `list`.
    List,
    /// `logs`: each line.
    Logs,
    /// `plot`.
    Plot,
    /// `record`.
    Record,
    /// `run`.
    Run,
    /// `status`.
    Status,
    /// `top`.
    Top,
    /// `replay --verify`.
    Verify,
}

impl OutputName {
    pub(crate) fn word(self) -> String {
        let value = self.to_possible_value();
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    }
}
