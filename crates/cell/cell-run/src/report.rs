//! The warnings of a run, the same for every way to run a cell: processes, one process, many
//! seeds, Python and the page.
//!
//! Each way has its place to show them, and none of them chooses among them. A warning that
//! only one way computes would be missing in the others.

use cell_model::Cell;
use cell_model::cells::script::ScriptLine;

use crate::phases;
use crate::script_report::ScriptReply;

/// Warnings about the files that `cell` was loaded from, each once.
pub fn of_cell(cell: &Cell) -> Vec<String> {
    let all = cell.arms.iter().flat_map(|arm| &arm.robot.warnings);
    let mut warnings: Vec<String> = Vec::new();
    for warning in all {
        // Arms of one kind are loaded from one file.
        if !warnings.contains(warning) {
            warnings.push(warning.clone());
        }
    }
    warnings
}

/// Warnings about a script: phases that are not in `drawing`, which has the nodes and states of
/// the policy.
pub fn of_script(script: &[ScriptLine], drawing: &str, cell: &Cell) -> Vec<String> {
    phases::unknown(script, drawing, &cell.name)
}

/// Warnings about lines of the script that were refused.
pub fn of_replies(replies: &[ScriptReply]) -> impl Iterator<Item = String> {
    let refused = replies.iter().filter(|reply| !reply.accepted);
    refused.map(ScriptReply::to_string)
}
