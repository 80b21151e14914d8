//! Costs of the cores, each in one run.

use crate::SimError;

/// Runs the bench `what`.
pub fn run(_what: &str, _json: bool) -> Result<(), SimError> {
    Ok(())
}
