//! Names of policies, and those of earlier builds.

use crate::suggest;

/// Name of the policy of a cell whose arms are all commanded by client programs.
pub const CLIENT_POLICY: &str = "client";

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
    format!("unknown policy '{asked}' for demo '{demo}'; {advice}")
}
