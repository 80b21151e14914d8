//! `[task]` of a cell file: its kind, and a table that the task program reads.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::check::Checker;
use crate::error::ModelError;
use crate::toml_text;

/// The keys of `[task]` that do not depend on its kind.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
pub struct TaskHead {
    /// Which job it is; the task program knows the other keys of this kind.
    pub kind: String,
    /// Program that does the job, where it is not the built-in one: a file
    /// beside the cell file, beside `robocell`, or on PATH.
    #[serde(default)]
    pub program: Option<String>,
}

/// The `[task]` table of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskTable {
    /// The keys of every kind.
    pub head: TaskHead,
    /// Name of the cell file in messages.
    pub file: String,
    text: Arc<str>,
}

impl TaskTable {
    /// The table in `text`, the whole cell file.
    pub(crate) fn new(head: TaskHead, file: &str, text: &str) -> Self {
        Self {
            head,
            file: file.to_owned(),
            text: text.into(),
        }
    }

    /// The kind of the job.
    pub fn kind(&self) -> &str {
        &self.head.kind
    }

    /// The other keys of the table as `T`.
    ///
    /// # Errors
    /// Returns [`ModelError`] with file, line and the known keys, for a key that is unknown or
    /// missing and for a value of another type.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, ModelError> {
        // Without the keys of `TaskHead`, which `T` would refuse.
        toml_text::parse_table(&self.file, &self.text, "task", &["kind", "program"])
    }

    /// A checker for values of the table; keys start with `task.`.
    pub fn checker(&self) -> Checker<'_> {
        Checker::new(&self.file, &self.text)
    }
}
