//! `[task]` with `kind = "fill_bin"`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::cell_check::Checker;
use crate::cell_file::CellFile;
use crate::error::ModelError;

/// Hold a bin under the dispenser until the grip breaks, and find it again.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FillBinTask {
    /// File in `cells/` that describes the behaviour.
    pub behaviour: String,
}

impl Checker<'_> {
    pub(crate) fn fill_bin(&self, task: &FillBinTask, _cell: &CellFile) -> Result<(), ModelError> {
        if task.behaviour.is_empty() {
            let allowed = "the name of a file in cells/ is needed";
            return Err(self.refuse("task.behaviour", "''", allowed));
        }
        Ok(())
    }
}
