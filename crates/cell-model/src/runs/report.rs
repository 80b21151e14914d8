//! The warnings of a run, the same for every way to run a cell: processes, one process, many
//! seeds, Python and the page.
//!
//! Each way has its place to show them, and none of them chooses among them. A warning that
//! only one way computes would be missing in the others.

use crate::cells::script::ScriptLine;
use crate::{Cell, suggest};

use super::phases;
use super::script_report::ScriptReply;

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

/// Kinds of `[task]` whose job is a file. Earlier builds used these names for their policies,
/// too; the second name is that of the policy now, which the built-in cells also use.
const FILE_POLICIES: [(&str, &str); 2] = [("tree", "json"), ("machine", "table")];

/// The policy of `known` with the name `asked`, or the one that had this name in an earlier
/// build.
pub fn policy_named<'k>(asked: &str, known: &[&'k str]) -> Option<&'k str> {
    let find = |name: &str| known.iter().copied().find(|policy| *policy == name);
    let today = || {
        let (_, name) = FILE_POLICIES.iter().find(|(kind, _)| *kind == asked)?;
        find(name)
    };
    find(asked).or_else(today)
}

/// The present name of a policy in a cell file with a task of `kind`.
pub(crate) fn policy_of_kind(kind: &str, policy: String) -> String {
    let known = FILE_POLICIES.iter().find(|(name, _)| *name == kind);
    match known {
        Some((name, today)) if policy == *name => (*today).to_owned(),
        _ => policy,
    }
}

/// The refusal of a policy that the job of `demo` does not have.
pub fn unknown_policy(asked: &str, known: &[&str], demo: &str) -> String {
    let advice = suggest::advice(asked, known);
    format!("there is no policy '{asked}' for demo '{demo}'; {advice}")
}
