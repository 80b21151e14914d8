//! `[task]` with `kind = "bin_stack"`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::cell_check::Checker;
use crate::cell_file::CellFile;
use crate::error::ModelError;

/// Bins off a conveyor into columns, all of them upside down.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinStackTask {
    /// File in `cells/` that describes the behaviour.
    pub behaviour: String,
}

impl Checker<'_> {
    pub(crate) fn bin_stack(
        &self,
        task: &BinStackTask,
        _cell: &CellFile,
    ) -> Result<(), ModelError> {
        if task.behaviour.is_empty() {
            let allowed = "the name of a file in cells/ is needed";
            return Err(self.refuse("task.behaviour", "''", allowed));
        }
        Ok(())
    }
}
