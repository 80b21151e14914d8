//! Times that cannot be met.

use crate::board::In;
use crate::finding::Finding;
use crate::tree::Host;
use crate::tree::spec::{Kind, Modifier, Node};

/// A time limit around a node.
struct Limit {
    id: String,
    seconds: f64,
}

pub(super) fn check<H: Host>(root: &Node<H>, findings: &mut Vec<Finding>) {
    node(root, &mut Vec::new(), findings);
}

fn node<H: Host>(node: &Node<H>, around: &mut Vec<Limit>, findings: &mut Vec<Finding>) {
    // Limits of this node apply to its children and not to its siblings.
    let before = around.len();
    // In the order of the modifiers, so that an outer limit applies to an inner pause.
    for modifier in &node.modifiers {
        match modifier {
            // Times from a key are known at run time only.
            Modifier::Timeout(In::Literal(seconds)) => limit(node, *seconds, around, findings),
            Modifier::Delay(In::Literal(seconds)) => pause(node, *seconds, around, findings),
            _ => {}
        }
    }
    match &node.kind {
        Kind::Timeout(In::Literal(seconds)) => limit(node, *seconds, around, findings),
        Kind::Wait(In::Literal(seconds)) => pause(node, *seconds, around, findings),
        _ => {}
    }
    for child in &node.children {
        // The path calls this function: a local of the same name hides it.
        self::node(child, around, findings);
    }
    around.truncate(before);
}

fn shortest(around: &[Limit]) -> Option<&Limit> {
    around.iter().min_by(|a, b| a.seconds.total_cmp(&b.seconds))
}

fn limit<H: Host>(
    node: &Node<H>,
    seconds: f64,
    around: &mut Vec<Limit>,
    findings: &mut Vec<Finding>,
) {
    if let Some(outer) = shortest(around)
        // Of equal ones the inner one runs out first: children are ticked before the limit of
        // their parent is checked.
        && seconds > outer.seconds
    {
        findings.push(Finding {
            rule: "timeout_longer",
            place: node.id.clone(),
            message: format!(
                "its timeout of {seconds} s can never run out, as that of '{}' around it is \
                 {} s; shorten it or take it out",
                outer.id, outer.seconds
            ),
        });
    }
    around.push(Limit {
        id: node.id.clone(),
        seconds,
    });
}

fn pause<H: Host>(node: &Node<H>, seconds: f64, around: &[Limit], findings: &mut Vec<Finding>) {
    if let Some(outer) = shortest(around)
        && seconds > outer.seconds
    {
        findings.push(Finding {
            rule: "always_times_out",
            place: node.id.clone(),
            message: format!(
                "waits {seconds} s, but '{}' around it times out after {} s; shorten the one or \
                 lengthen the other",
                outer.id, outer.seconds
            ),
        });
    }
}
