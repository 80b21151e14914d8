//! Replaced leaves of trees, which return a fixed result without being run.

use std::collections::BTreeMap;
use std::time::Duration;

use behavior::Status;
use behavior::tree::{Host, ReplaceError, Replacement, Tree};
use cell_model::cells::replace::{Replace, ReplacedAnswer};

/// Replaces leaves of `trees`; a rule applies to each tree that contains its node.
///
/// # Errors
/// The first rule whose node is a leaf of no tree.
pub fn replace_leaves<'t, H: Host>(
    trees: impl IntoIterator<Item = &'t mut Tree<H>>,
    rules: &[Replace],
) -> Result<(), String> {
    // One call per node with all its rules: a second call would wrap the replaced leaf, and
    // the last rule would win in place of the first.
    let mut by_node: BTreeMap<&str, Vec<Replacement>> = BTreeMap::new();
    for rule in rules {
        let replacements = by_node.entry(&rule.node).or_default();
        replacements.push(replacement(rule));
    }
    let mut trees: Vec<&mut Tree<H>> = trees.into_iter().collect();
    for (node, replacements) in by_node {
        let mut refused = None;
        let mut found = false;
        for tree in &mut trees {
            match tree.replace(node, replacements.clone()) {
                Ok(()) => found = true,
                // An existing node that is not a leaf explains more than a missing one.
                Err(error @ ReplaceError::NoLeaf { .. }) => refused = Some(error),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        match refused {
            // Found in one tree is enough: the trees of two arms need not have the same leaves.
            Some(error) if !found => return Err(error.to_string()),
            _ => {}
        }
    }
    Ok(())
}

fn replacement(rule: &Replace) -> Replacement {
    // More seconds than a `Duration` can hold mean "for ever".
    let seconds = |seconds: f64| Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    let from = seconds(rule.from_s);
    Replacement {
        answer: match rule.result {
            ReplacedAnswer::Success => Status::Success,
            ReplacedAnswer::Failure => Status::Failure,
            ReplacedAnswer::Running => Status::Running,
        },
        from,
        until: rule.for_s.map(|time| from.saturating_add(seconds(time))),
    }
}
