//! Pictures, written out by hand.

use behavior::graph::{Graph, GraphEdge, GraphKind, GraphNode};
use behavior::{NodeStatus, views};

fn node(kind: &str, name: &str, parent: Option<usize>, detail: &str) -> GraphNode {
    GraphNode {
        id: name.to_owned(),
        kind: kind.to_owned(),
        name: name.to_owned(),
        parent,
        detail: detail.to_owned(),
    }
}

fn edge(from: usize, to: usize, label: &str) -> GraphEdge {
    let label = label.to_owned();
    GraphEdge { from, to, label }
}

fn tree() -> Graph {
    Graph {
        kind: GraphKind::Tree,
        name: "demo".to_owned(),
        nodes: vec![
            node("Selector", "Root", None, ""),
            node("Sequence", "Recovery", Some(0), "[Timeout seconds=2]"),
            node("condition IsDropped", "dropped?", Some(1), ""),
            node("Clear", "clear", Some(1), ""),
            node("MoveTo", "say \"<b>\"\n#1", Some(0), "speed=2"),
        ],
        edges: vec![],
    }
}

fn machine() -> Graph {
    Graph {
        kind: GraphKind::Machine,
        name: "lights".to_owned(),
        nodes: vec![
            node("state", "off", None, ""),
            node("state", "on", None, ""),
            node("state", "dim", Some(1), ""),
            node("state", "bright", Some(1), ""),
        ],
        edges: vec![
            edge(0, 1, "press [has_power]"),
            edge(1, 0, "press"),
            edge(2, 3, "turn"),
        ],
    }
}

const TREE: [NodeStatus; 5] = [
    NodeStatus::Running,
    NodeStatus::Failure,
    NodeStatus::Success,
    NodeStatus::Invalid,
    NodeStatus::Halting,
];

#[test]
fn a_tree_in_a_terminal() {
    let wanted = "\
? Root (Selector) *
├── → Recovery (Sequence)  [Timeout seconds=2] ✗
│   ├── dropped? (condition IsDropped) ✓
│   └── clear -
└── say \"<b>\" #1 (MoveTo)  speed=2 ~
";
    assert_eq!(views::text(&tree(), Some(&TREE)), wanted);
    let plain = views::text(&tree(), None);
    assert!(
        plain.contains("│   ├── dropped? (condition IsDropped)\n"),
        "{plain}"
    );
}

#[test]
fn states_in_a_terminal() {
    let wanted = "\
off
  → on: press [has_power]
on *
│ → off: press
├── dim *
│     → bright: turn
└── bright
";
    let statuses = [
        NodeStatus::Invalid,
        NodeStatus::Running,
        NodeStatus::Running,
        NodeStatus::Invalid,
    ];
    assert_eq!(views::text(&machine(), Some(&statuses)), wanted);
}

#[test]
fn mermaid_gets_a_chart_with_harmless_names() {
    let wanted = "\
flowchart TD
  n0[\"Root (Selector)\"]
  n1[\"Recovery (Sequence)\"]
  n2{{\"dropped? (condition IsDropped)\"}}
  n3[\"clear\"]
  n4[\"say #34;#60;b#62;#34; #35;1 (MoveTo)\"]
  n0 --> n1
  n0 --> n4
  n1 --> n2
  n1 --> n3
";
    assert_eq!(views::mermaid(&tree(), None), wanted);
    let coloured = views::mermaid(&tree(), Some(&TREE));
    assert!(coloured.ends_with(
        "  classDef running fill:#fff3bf,stroke:#e67700
  class n0 running
  classDef success fill:#d3f9d8,stroke:#2b8a3e
  class n2 success
  classDef failure fill:#ffe3e3,stroke:#c92a2a
  class n1 failure
  classDef halting fill:#e5dbff,stroke:#5f3dc4
  class n4 halting
"
    ));
}

#[test]
fn mermaid_draws_states_in_their_parents() {
    let wanted = "\
flowchart LR
  n0([\"off\"])
  subgraph n1[\"on\"]
  n2([\"dim\"])
  n3([\"bright\"])
  end
  n0 -->|\"press [has_power]\"| n1
  n1 -->|\"press\"| n0
  n2 -->|\"turn\"| n3
";
    assert_eq!(views::mermaid(&machine(), None), wanted);
}

#[test]
fn a_graph_that_makes_no_sense_is_drawn_all_the_same() {
    let graph = Graph {
        kind: GraphKind::Code,
        name: String::new(),
        nodes: vec![
            node("", "", Some(0), ""),
            node("", "b", Some(9), ""),
            node("", "c", Some(1), "\u{1b}[2J"),
        ],
        edges: vec![edge(7, 0, "x"), edge(2, 9, "y")],
    };
    for view in [views::text, views::mermaid] {
        assert!(!view(&graph, Some(&[])).contains('\u{1b}'));
    }
    let deep = Graph {
        kind: GraphKind::Tree,
        name: String::new(),
        nodes: (0..3000)
            .map(|i| node("k", "n", usize::checked_sub(i, 1), ""))
            .collect(),
        edges: vec![],
    };
    assert_eq!(views::text(&deep, None).lines().count(), 3000);
}

fn matrix() -> Graph {
    Graph {
        kind: GraphKind::Matrix,
        name: "lamp".to_owned(),
        nodes: vec![
            node("state", "OFF", None, "PRESS: switch_on"),
            node(
                "state",
                "ON",
                None,
                "runs blink, STOP: give_up, PRESS: switch_off",
            ),
        ],
        edges: vec![
            edge(0, 1, "PRESS"),
            edge(1, 0, "STOP"),
            edge(1, 0, "PRESS"),
            edge(1, 1, "PRESS"),
        ],
    }
}

#[test]
fn a_matrix_in_a_terminal_has_a_row_for_each_event() {
    let wanted = "       OFF        ON *
runs              blink
STOP              give_up
                  → OFF
PRESS  switch_on  switch_off
       → ON       → OFF | ON
";
    let statuses = [NodeStatus::Invalid, NodeStatus::Running];
    assert_eq!(views::matrix(&matrix(), Some(&statuses), 80), wanted);
}

#[test]
fn a_matrix_that_is_too_wide_is_turned_or_continued_below() {
    // Many states and few events: a row for each state is narrower.
    let mut wide = matrix();
    for state in 0..20 {
        wide.nodes.push(node(
            "state",
            &format!("STATE_{state}"),
            None,
            "STOP: give_up",
        ));
    }
    let text = views::matrix(&wide, None, 60);
    let first = text
        .lines()
        .next()
        .map(|line| line.split_whitespace().collect());
    assert_eq!(first, Some(vec!["runs", "STOP", "PRESS"]));
    assert!(
        text.lines().all(|line| line.chars().count() <= 60),
        "{text}"
    );

    let text = views::matrix(&wide, None, 30);
    assert!(
        text.lines().all(|line| line.chars().count() <= 30),
        "{text}"
    );
    let states = (0..20).map(|state| format!("STATE_{state}"));
    let missing: Vec<_> = states.filter(|state| !text.contains(state)).collect();
    assert!(missing.is_empty(), "{missing:?} in {text}");
}
