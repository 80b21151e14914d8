//! Composites without children, and children of a parallel that drive the same thing.

use std::collections::BTreeMap;

use crate::finding::Finding;
use crate::tree::spec::{Kind, Node};
use crate::tree::{Host, Library};

/// The first leaf that drives a thing, by the name of the thing.
type Driven<'n> = BTreeMap<&'static str, &'n str>;

pub(super) fn check<H: Host>(root: &Node<H>, library: &Library<H>, findings: &mut Vec<Finding>) {
    node(root, library, findings);
}

/// Checks a node and all below it; returns what these drive. Recursion has the depth of the
/// tree.
fn node<'n, H: Host>(
    it: &'n Node<H>,
    library: &Library<H>,
    findings: &mut Vec<Finding>,
) -> Driven<'n> {
    empty(it, findings);
    let mut all = Driven::new();
    if matches!(it.kind, Kind::Leaf(_)) {
        let drives = library.find(&it.type_name).and_then(|known| known.drives);
        all.extend(drives.map(|what| (what, it.id.as_str())));
    }
    // Only a parallel ticks both in every tick; elsewhere one ends before the next starts.
    let is_parallel = matches!(it.kind, Kind::Parallel(_));
    for child in &it.children {
        for (what, leaf) in node(child, library, findings) {
            match all.get(what) {
                Some(first) if is_parallel => findings.push(Finding {
                    rule: "parallel_drivers",
                    place: it.id.clone(),
                    message: format!(
                        "'{first}' and '{leaf}' drive the same {what} at every tick, and the one that \
                         is asked last wins; put them into a Sequence"
                    ),
                }),
                Some(_) => {}
                // The first leaf is kept: the message names it together with each later one.
                None => drop(all.insert(what, leaf)),
            }
        }
    }
    all
}

fn empty<H: Host>(it: &Node<H>, findings: &mut Vec<Finding>) {
    let answer = match it.kind {
        Kind::Sequence(_) | Kind::SequenceWithMemory | Kind::Parallel(_) => "succeeds",
        Kind::Selector(_) => "fails",
        _ => return,
    };
    if it.children.is_empty() {
        findings.push(Finding {
            rule: "empty_composite",
            place: it.id.clone(),
            message: format!("has no children, so it {answer} at once; give it some, or drop it"),
        });
    }
}
