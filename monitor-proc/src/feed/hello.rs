//! The first message to a page: the run and the demos.

use serde::Serialize;

/// The run as the page names it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RunInfo {
    /// 16 hexadecimal digits.
    pub id: String,
    /// Name of the cell.
    pub cell: String,
    /// The command that a person started it with; empty where none did.
    pub command: String,
    /// Name of the demo.
    pub demo: String,
    /// Name of the policy.
    pub policy: String,
    /// Seed of the run.
    pub seed: u64,
    /// `1`, `max`, or a factor.
    pub speed: String,
}

/// A demo that can be loaded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DemoInfo {
    /// Its name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// Policies that can run it.
    pub policies: Vec<String>,
    /// The policy used if none is given.
    pub default_policy: String,
}

/// First message to a client, without its role.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hello {
    /// False for a replayed file.
    pub live: bool,
    /// The run.
    pub run: RunInfo,
    /// Demos that can be loaded.
    pub demos: Vec<DemoInfo>,
    /// Name of the replayed file.
    pub source: Option<String>,
}
