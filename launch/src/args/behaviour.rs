//! The command line of behaviours and of schemas.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::args::common::{CellArgs, DataArgs, ProgramArgs};
use crate::args::kinds::OutputName;

/// `robocell bt`.
#[derive(Clone, Debug, Args)]
pub struct TreeArgs {
    /// The action.
    #[command(subcommand)]
    pub verb: TreeVerb,
}

/// Actions on a tree.
#[derive(Clone, Debug, Subcommand)]
pub enum TreeVerb {
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    Behaviour(BehaviourVerb),
    /// Print a tree of BehaviorTree.CPP 4 as a tree file
    Import(ImportArgs),
}

/// `import`.
#[derive(Clone, Debug, Args)]
pub struct ImportArgs {
    /// The XML of the tree; files that it includes are read, too
    pub file: PathBuf,
    /// The tree to execute [default: the one that the file names]
    #[arg(long, value_name = "NAME")]
    pub tree: Option<String>,
    /// A tree file whose subtrees provide the leaves of their names; the printed file includes it
    /// from its own folder
    #[arg(long, value_name = "FILE")]
    pub leaves: Option<PathBuf>,
}

/// `robocell fsm`.
#[derive(Clone, Debug, Args)]
pub struct BehaviourArgs {
    /// The action.
    #[command(subcommand)]
    pub verb: BehaviourVerb,
}

/// Actions on a behaviour.
#[derive(Clone, Debug, Subcommand)]
pub enum BehaviourVerb {
    /// Print it as text, mermaid or dot, or live
    Show(ShowArgs),
    /// Check a file: errors, and probable mistakes
    Check(CheckArgs),
}

/// `show`.
#[derive(Clone, Debug, Args)]
pub struct ShowArgs {
    /// A demo or a file [default: the policy of the running cell]
    #[arg(value_name = "DEMO|FILE")]
    pub what: Option<String>,
    /// Policy of the demo [default: that of the demo]
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    /// How to print it
    #[arg(long, value_enum, default_value_t = PictureFormat::Text)]
    pub format: PictureFormat,
    /// Print the policy of the running cell whenever something in it changes
    #[arg(long, conflicts_with_all = ["what", "policy", "format"])]
    pub live: bool,
    /// With `--live`: only the picture of this arm
    #[arg(long, requires = "live", value_name = "NAME")]
    pub arm: Option<String>,
    /// With `--live`: print once
    #[arg(long, requires = "live")]
    pub once: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}

/// `check`.
#[derive(Clone, Debug, Args)]
pub struct CheckArgs {
    /// A tree (JSON), the cell file of trees (TOML), or a machine or matrix (TOML or JSON)
    pub file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub program: ProgramArgs,
}

/// How a behaviour is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PictureFormat {
    /// For the terminal; a matrix as a table of events and states
    Text,
    /// For markdown
    Mermaid,
}

impl PictureFormat {
    /// The word on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Mermaid => "mermaid",
        }
    }
}

/// `robocell schema`.
#[derive(Clone, Debug, Args)]
pub struct SchemaArgs {
    /// Kind of file or output
    pub what: SchemaKind,
    /// With `output`: the command [default: list all]
    #[arg(value_name = "NAME")]
    pub name: Option<OutputName>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub program: ProgramArgs,
}

/// Something with a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SchemaKind {
    /// Behaviour trees, with the node types of the demos
    Tree,
    /// State machines and matrices
    Machine,
    /// `cells/NAME.toml`
    Cell,
    /// Output of a command with `--json`
    Output,
    /// Messages between the processes: layouts, codes and topics
    Wire,
}

impl SchemaKind {
    /// The word on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::Machine => "machine",
            Self::Cell => "cell",
            Self::Output => "output",
            Self::Wire => "wire",
        }
    }
}
