//! What commands print with `--json`: one object on the last line, or one a line.

use serde::Serialize;
use supervisor::failure::Failure;

use crate::say;

/// Prints `value` as one object.
pub(crate) fn print(value: &impl Serialize) -> Result<(), Failure> {
    say::line(serde_json::to_string(value).map_err(Failure::configuration)?);
    Ok(())
}
