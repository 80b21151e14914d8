//! Zones that two arms take in opposite order: each may wait for the other for ever.

use std::collections::BTreeSet;

use behavior::Graph;
use behavior::graph::GraphNode;

/// The port of a node that works in a zone, with its other name.
const IN_ZONE: [&str; 2] = ["in_zone=true", "in_center=true"];

/// A warning for each pair of zones that two trees take in opposite order; `arms` are the names
/// and trees of arms with one blackboard.
pub(super) fn warnings(arms: &[(&str, &Graph)]) -> Vec<String> {
    let orders: Vec<_> = arms
        .iter()
        .map(|(arm, of)| (*arm, taken_within(of)))
        .collect();
    let mut warnings = Vec::new();
    for (index, (arm, order)) in orders.iter().enumerate() {
        for (other, theirs) in orders.iter().skip(index + 1) {
            let opposite = |(held, taken): &&(&str, &str)| theirs.contains(&(*taken, *held));
            // Short, since it is a line of the log.
            warnings.extend(order.iter().filter(opposite).map(|(held, taken)| {
                format!(
                    "deadlock possible: {arm} enters {} in {}, {other} the other way round; enter \
                     them in one order",
                    quoted(taken),
                    quoted(held)
                )
            }));
        }
    }
    warnings
}

fn quoted(zone: &str) -> String {
    if zone.is_empty() {
        return "the tree's own zone".to_owned();
    }
    format!("zone '{zone}'")
}

/// Pairs of zones in the order of the nodes: one that is owned, and one that is taken then.
fn taken_within(tree: &Graph) -> BTreeSet<(&str, &str)> {
    let (mut owned, mut pairs) = (BTreeSet::new(), BTreeSet::new());
    for node in &tree.nodes {
        let zone = zone(node);
        if node.kind == "LeaveZone" {
            owned.remove(zone);
        } else if node.kind == "EnterZone" || IN_ZONE.iter().any(|on| node.detail.contains(on)) {
            let others = owned.iter().filter(|known| **known != zone);
            pairs.extend(others.map(|held| (*held, zone)));
            owned.insert(zone);
        }
    }
    pairs
}

/// The zone of a node, from its ports; empty for the tree's own.
fn zone(node: &GraphNode) -> &str {
    let mut ports = node.detail.split(' ');
    let zone = ports.find_map(|port| port.strip_prefix("zone="));
    // Its modifiers follow after a semicolon.
    zone.map_or("", |zone| zone.trim_end_matches(';').trim_matches('\''))
}

#[cfg(test)]
mod tests {
    use behavior::graph::GraphKind;

    use super::*;

    fn tree(nodes: &[(&str, &str)]) -> Graph {
        let node = |(kind, zone): &(&str, &str)| GraphNode {
            id: String::new(),
            kind: (*kind).to_owned(),
            name: String::new(),
            parent: None,
            detail: format!("zone='{zone}'"),
        };
        Graph {
            kind: GraphKind::Tree,
            name: String::new(),
            nodes: nodes.iter().map(node).collect(),
            edges: Vec::new(),
        }
    }

    #[test]
    fn two_zones_in_opposite_order_are_a_warning_and_in_one_order_or_alone_none() {
        let nested = |a, b| tree(&[("EnterZone", a), ("EnterZone", b), ("EnterZone", b)]);
        let (ab, ba) = (nested("A", "B"), nested("B", "A"));
        let alone = tree(&[("EnterZone", "B"), ("LeaveZone", "B"), ("EnterZone", "A")]);
        let found = |other| warnings(&[("left", &ab), ("right", other)]);
        let warning = "deadlock possible: left enters zone 'B' in zone 'A', right the other way \
                       round; enter them in one order";
        assert_eq!(found(&ba), [warning]);
        assert_eq!((found(&ab), found(&alone)), (vec![], vec![]));
    }
}
