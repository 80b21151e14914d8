use super::*;
use ipc_types::{Text, Wire};

fn line(kind: TraceKind, node: u32, from: u32, to: u32, text: &str) -> TraceLine {
    let mut line = TraceLine::zeroed();
    line.kind = kind.code();
    (line.node, line.from, line.to) = (node, from, to);
    line.text = Text::new(text);
    line
}

fn machine() -> TraceModel {
    machine_of(&["open", "shut"])
}

fn machine_of(names: &[&str]) -> TraceModel {
    let mut trace = TraceModel::default();
    for (node, name) in (0..).zip(names) {
        let text = format!("door\u{1f}{name}\u{1f}state\u{1f}{name}\u{1f}");
        let count = u32::try_from(names.len()).unwrap();
        trace.take(&line(TraceKind::Node, node, 0, count, &text));
    }
    trace.take(&line(TraceKind::Edge, 0, 0, 1, "push"));
    trace
}

fn kinds(messages: &[Value]) -> Vec<&str> {
    messages.iter().filter_map(|m| m["t"].as_str()).collect()
}

#[test]
fn a_machine_shows_the_way_it_took() {
    let mut trace = machine();
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R-"));
    let first = trace.take_changes();
    assert_eq!(kinds(&first), ["graphs", "statuses"]);
    assert_eq!(first[0]["graphs"][0]["kind"], "machine");
    assert_eq!(first[1]["letters"], "RI");
    trace.take(&line(TraceKind::Status, 0, 1, 0, ""));
    trace.take(&line(TraceKind::Status, 1, 0, 1, ""));
    let second = trace.take_changes();
    assert_eq!(kinds(&second), ["statuses", "edge"]);
    assert_eq!(
        (&second[1]["label"], &second[1]["to"]),
        (&json!("push"), &json!(1))
    );
    assert!(trace.take_changes().is_empty());
}

#[test]
fn the_way_into_the_last_state_is_shown() {
    for ended in [2, 3] {
        let mut trace = machine();
        trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R-"));
        trace.take(&line(TraceKind::Status, 0, 1, 0, "push"));
        trace.take(&line(TraceKind::Status, 1, 0, ended, "push"));
        let edge = trace.take_changes().into_iter().find(|m| m["t"] == "edge");
        assert_eq!(edge.expect("an edge")["to"], 1, "status {ended}");
    }
}

#[test]
fn the_way_out_of_the_last_state_is_shown() {
    let mut trace = machine();
    trace.take(&line(TraceKind::Edge, 0, 1, 0, "again"));
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "-S"));
    trace.take_changes();
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R-"));
    let edge = trace.take_changes().into_iter().find(|m| m["t"] == "edge");
    assert_eq!(edge.expect("an edge")["label"], "again");
}

#[test]
fn the_way_back_to_a_state_of_lower_number_is_shown() {
    let mut trace = machine();
    trace.take(&line(TraceKind::Edge, 0, 1, 0, "back"));
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "-R"));
    trace.take_changes();
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R-"));
    let edge = trace.take_changes().into_iter().find(|m| m["t"] == "edge");
    let edge = edge.expect("an edge");
    assert_eq!((&edge["label"], &edge["to"]), (&json!("back"), &json!(0)));
}

#[test]
fn a_reset_is_no_transition() {
    let mut trace = machine();
    trace.take(&line(TraceKind::Edge, 0, 1, 0, "back"));
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R-"));
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "-R"));
    trace.take_changes();
    trace.take(&line(TraceKind::Lifecycle, 0, 0, 0, "[task] reset"));
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R-"));
    let edge = trace.take_changes().into_iter().find(|m| m["t"] == "edge");
    assert!(edge.expect("that there is none")["to"].is_null());
    let mut next = line(TraceKind::Statuses, 0, 0, 0, "-R");
    next.header.sim_time_ns = 500_000_000;
    trace.take(&next);
    let edge = trace.take_changes().into_iter().find(|m| m["t"] == "edge");
    assert_eq!(edge.expect("an edge")["to"], 1);
}

#[test]
fn of_a_state_that_is_passed_within_a_decision_the_way_out_is_shown() {
    let mut trace = machine_of(&["open", "shut", "gone"]);
    trace.take(&line(TraceKind::Edge, 0, 1, 2, "pull off"));
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R--"));
    trace.take_changes();
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "--R"));
    let edge = trace.take_changes().into_iter().find(|m| m["t"] == "edge");
    let edge = edge.expect("an edge");
    assert_eq!(
        (&edge["from"], &edge["label"]),
        (&json!(1), &json!("pull off"))
    );
}

/// A machine with four edges from one state to the other.
fn doors() -> TraceModel {
    let mut trace = machine();
    for label in ["pull [locked, not bent]", "pull [not locked]", "kick"] {
        trace.take(&line(TraceKind::Edge, 0, 0, 1, label));
    }
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R-"));
    trace
}

/// Guards that were evaluated, and their results.
type Asked<'a> = &'a [(&'a str, u32)];

#[test]
fn of_rows_that_lead_the_same_way_the_one_that_fired_is_named() {
    let cases: [(&str, Asked<'_>, &str); 5] = [
        ("kick", &[], "kick"),
        (
            "pull",
            &[("locked", 1), ("bent", 0)],
            "pull [locked, not bent]",
        ),
        ("pull", &[("locked", 0)], "pull [not locked]"),
        ("push", &[], "push"),
        // No row of the table: the state that was left is not known.
        ("lost", &[], "lost"),
    ];
    for (reason, guards, label) in cases {
        let mut trace = doors();
        for (name, holds) in guards {
            trace.take(&line(TraceKind::Guard, 0, 0, *holds, name));
        }
        trace.take(&line(TraceKind::Status, 0, 1, 0, reason));
        trace.take(&line(TraceKind::Status, 1, 0, 1, reason));
        let edge = trace.take_changes().into_iter().find(|m| m["t"] == "edge");
        assert_eq!(edge.unwrap()["label"], label, "{reason} {guards:?}");
    }
}

#[test]
fn an_answer_that_stays_the_same_is_told_again_after_half_a_second() {
    let mut trace = machine();
    let mut sent = Vec::new();
    for tenth in 0..12_u64 {
        let mut guards = line(TraceKind::Guard, 1, 0, 1, "guard");
        guards.header.sim_time_ns = tenth * 100_000_000;
        trace.take(&guards);
        if trace
            .take_changes()
            .iter()
            .any(|message| message["t"] == "guards")
        {
            sent.push(tenth);
        }
    }
    assert_eq!(sent, [0, 5, 10]);
}

#[test]
fn only_what_changed_is_told_and_a_late_joiner_is_told_all() {
    let mut trace = machine();
    trace.take(&line(TraceKind::Key, 0, 0, 0, "local.cube=red"));
    trace.take(&line(TraceKind::Guard, 1, 0, 1, "guard"));
    let mut drop = line(TraceKind::Log, 0, 0, 0, "<script>alert(1)</script>");
    drop.event = TraceEvent::Drop.code();
    trace.take(&drop);
    trace.take_changes();
    trace.take(&line(TraceKind::Key, 0, 0, 0, "local.cube=red"));
    trace.take(&line(TraceKind::Guard, 1, 0, 0, "guard"));
    let changes = trace.take_changes();
    assert_eq!(
        changes,
        [json!({ "t": "guards", "graph": 0, "values": { "shut": false }, "time_s": 0.0 })]
    );
    let all = trace.full_state();
    assert_eq!(kinds(&all), ["graphs", "statuses", "keys", "guards", "log"]);
    assert_eq!(all[4]["lines"][0]["mark"], "drop");
    assert_eq!(all[4]["lines"][0]["text"], "<script>alert(1)</script>");
}

#[test]
fn a_change_has_its_time_and_a_node_that_runs_again_is_told() {
    let mut trace = machine();
    trace.take(&line(TraceKind::Statuses, 0, 0, 0, "R-"));
    trace.take_changes();
    for (time_ns, status) in [(1_500_000_000, 2), (1_510_000_000, 1)] {
        let mut change = line(TraceKind::Status, 0, 1, status, "");
        change.header.sim_time_ns = time_ns;
        trace.take(&change);
    }
    let changes = trace.take_changes();
    let statuses = changes.iter().find(|m| m["t"] == "statuses").unwrap();
    assert_eq!(
        (&statuses["letters"], &statuses["started"]),
        (&json!("RI"), &json!([0]))
    );
    assert_eq!(statuses["time_s"], 1.51);
    let known = trace.full_state();
    let known = known.iter().find(|m| m["t"] == "statuses").unwrap();
    assert!(known["time_s"].is_null() && known["started"].is_null());
}

#[test]
fn an_incident_is_a_line_with_its_number() {
    let head = json!({
        "number": 3, "what": "task was killed", "at": "", "sim_time_s": 1.5, "run": 1,
        "demo": "", "policy": "", "seed": 0, "version": "", "complete": false
    });
    let mut trace = TraceModel::default();
    trace.add_incident(
        &serde_json::from_value(head).unwrap(),
        "task was killed (SIGKILL)",
    );
    let line = &trace.take_changes()[0]["lines"][0];
    assert_eq!(line["text"], "incident 3: task was killed (SIGKILL)");
    assert_eq!(
        (&line["mark"], &line["incident"]),
        (&"incident".into(), &3.into())
    );
    assert_eq!(line["time_s"], 1.5);
}

#[test]
fn half_a_picture_is_not_shown_and_another_policy_replaces_all() {
    let mut trace = machine();
    trace.take_changes();
    let half = "tree\u{1f}root\u{1f}selector\u{1f}Root\u{1f}";
    trace.take(&line(TraceKind::Node, 0, 0, 2, half));
    assert!(!kinds(&trace.take_changes()).contains(&"graphs"));
    let rest = "tree\u{1f}lift\u{1f}action\u{1f}Lift\u{1f}";
    trace.take(&line(TraceKind::Node, 1, 1, 2, rest));
    let changes = trace.take_changes();
    assert_eq!(changes[0]["graphs"][0]["kind"], "tree");
    assert_eq!(changes[0]["graphs"][0]["edges"], json!([]));
    assert_eq!(changes[0]["graphs"][0]["nodes"][1]["parent"], 0);
}

#[test]
fn nonsense_is_left_out_and_the_log_is_bounded() {
    let mut trace = TraceModel::default();
    trace.take(&line(TraceKind::Node, 7, 0, 3, "x"));
    trace.take(&line(TraceKind::Node, 0, 0, u32::MAX, "x"));
    trace.take(&line(TraceKind::Statuses, u32::MAX, 9, 9, "RR"));
    trace.take(&line(TraceKind::Edge, 0, 1, 2, "x"));
    trace.take(&line(TraceKind::Key, 0, 1, 2, "a=b"));
    let changes = trace.take_changes();
    assert_eq!(
        kinds(&changes),
        ["log"],
        "a graph too large is reported: {changes:?}"
    );
    for _ in 0..2000 {
        trace.add_log_line(0.0, "log", TraceEvent::None, "x");
    }
    assert_eq!(
        trace.full_state()[1]["lines"].as_array().unwrap().len(),
        KEPT_LINES
    );
}

#[test]
fn edges_beyond_the_limit_are_reported_once() {
    let mut trace = machine();
    for label in 0..MAX_EDGES + 5 {
        trace.take(&line(TraceKind::Edge, 0, 0, 1, &label.to_string()));
    }
    let changes = trace.take_changes();
    let log = changes.iter().find(|m| m["t"] == "log").expect("a report");
    let lines = log["lines"].as_array().expect("lines");
    assert_eq!(lines.len(), 1);
    let text = lines[0]["text"].as_str().expect("text");
    assert!(text.contains("4096 edges"), "{text}");
}
