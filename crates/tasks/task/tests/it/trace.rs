//! Pictures, statuses and breakpoints of a policy in plain code, and warnings.

use behavior::board::Board;
use behavior::graph::{Graph, GraphKind};
use behavior::value::ValueType;
use behavior::{NodeStatus, Str, Value};
use cell_model::Cell;
use ipc_types::trace::{FIELD_END, LINE_BYTES, TraceKind};
use ipc_types::{BreakName, Decision, Text, Wire as _};
use robocell_task::tree_trace::KeyWatch;
use robocell_task::{AnyPolicy, Job, Observation, Output, Policy, Task, boxed, ring};

use crate::bench::{Bench, GRIP_FORCE_N, Plan, load, worker};

fn statuses(bench: &Bench) -> Vec<(usize, u32, u32)> {
    let lines = bench.lines.iter();
    let lines = lines.filter(|line| line.kind == TraceKind::Status);
    lines.map(|line| (line.node, line.from, line.to)).collect()
}

#[test]
fn the_phases_of_code_are_a_ring_and_each_change_is_told_once() {
    let mut bench = Bench::new(Plan::default());
    let [graph] = bench.task.graphs() else {
        panic!("one picture")
    };
    let names: Vec<&str> = graph.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["FETCH", "BRING", "PUT"]);
    let edges: Vec<(usize, usize)> = graph.edges.iter().map(|e| (e.from, e.to)).collect();
    assert_eq!(edges, [(0, 1), (1, 2), (2, 0)]);
    let (runs, idle) = (NodeStatus::Running as u32, NodeStatus::Invalid as u32);
    bench.decide();
    assert_eq!(statuses(&bench), [(0, idle, runs)]);
    bench.decide_times(8);
    assert_eq!(statuses(&bench), []);
    bench.decide();
    assert_eq!(statuses(&bench), [(0, runs, idle), (1, idle, runs)]);
    let mut lines = Vec::new();
    bench.task.trace_statuses(&mut lines);
    let letters = [
        NodeStatus::Invalid,
        NodeStatus::Running,
        NodeStatus::Invalid,
    ];
    let letters: String = letters.iter().map(|status| status.letter()).collect();
    assert_eq!(lines[0].text.as_str(), letters);
    bench.decide_times(19);
    bench.decide();
    // The phase that is left first, although its number is higher.
    assert_eq!(statuses(&bench), [(2, runs, idle), (0, idle, runs)]);
}

fn breaks(bench: &mut Bench, name: &str) {
    bench.state.panel.break_count = 1;
    bench.state.panel.breaks[0] = BreakName::new(name);
}

/// The status of a phase is not in the checkpoint: a restored task took the phase in which it
/// was for one that starts, and paused the cell at its breakpoint.
#[test]
fn a_restored_task_does_not_reach_the_breakpoint_of_the_phase_it_is_in() {
    let mut bench = Bench::new(Plan::default());
    bench.decide_times(12);
    breaks(&mut bench, "BRING");
    bench.decide();
    assert_eq!(
        (bench.decision.phase.as_str(), bench.decision.break_tick),
        ("BRING", 0)
    );
    let record = bench.task.checkpoint();
    bench.task = worker(Plan::default());
    bench.task.restore(&record).unwrap();
    bench.decide();
    assert_eq!(bench.decision.break_tick, 0, "it entered nothing");
    bench.decide_times(30);
    // BRING starts with decision 40.
    assert_eq!(bench.decision.break_tick, 400);
    assert_eq!(bench.decision.break_name, BreakName::new("BRING"));
    let record = bench.task.checkpoint();
    bench.task = worker(Plan::default());
    bench.task.restore(&record).unwrap();
    bench.decide();
    assert_eq!(bench.decision.break_tick, 400, "the same one as before");
}

/// A tree with more nodes than a line has room for.
struct Large;

/// Nodes of its picture.
const NODES: usize = LINE_BYTES + 40;

impl Policy for Large {
    type Memory = ();

    fn decide(&self, (): &mut (), _: &Observation<'_>, _: &mut Job, _: &mut Output) {}

    fn describe(&self, name: &str) -> Graph {
        let mut nodes: Vec<_> = (0..NODES)
            .map(|n| ring::node(&format!("n{n}"), "what it does"))
            .collect();
        nodes[1].parent = Some(0);
        Graph {
            kind: GraphKind::Tree,
            name: name.to_owned(),
            nodes,
            edges: vec![ring::edge(3, 4, "over")],
        }
    }

    fn statuses(&self, (): &(), out: &mut Vec<NodeStatus>) {
        out.extend((0..NODES).map(|node| ring::running_if(node == LINE_BYTES + 1)));
    }
}

#[test]
fn a_picture_of_any_size_is_sent_in_lines_that_can_be_put_together() {
    let mut task = Task::new(&load("franka-pyramid"), "large", GRIP_FORCE_N, boxed(Large));
    let mut lines = Vec::new();
    let count = task.picture_lines();
    assert_eq!(count, NODES + 1);
    // In pieces, as a task process sends them.
    for from in (0..count).step_by(7) {
        task.trace_pictures(from..from + 7, &mut lines);
    }
    assert_eq!(lines.len(), count);
    let fields: Vec<&str> = lines[1].text.as_str().split(FIELD_END).collect();
    assert_eq!(fields, ["large", "n1", "phase", "n1", "what it does"]);
    // The parent counts from 1, and each line has the number of all nodes.
    let place = |line: usize| (lines[line].node, lines[line].from, lines[line].to as usize);
    assert_eq!((place(0), place(1)), ((0, 0, NODES), (1, 1, NODES)));
    let edge = lines.last().unwrap();
    assert_eq!((edge.kind, edge.from, edge.to), (TraceKind::Edge, 3, 4));
    lines.clear();
    task.trace_statuses(&mut lines);
    let places: Vec<_> = lines
        .iter()
        .map(|line| (line.node, line.text.as_str().len()))
        .collect();
    assert_eq!(places, [(0, LINE_BYTES), (LINE_BYTES, 40)]);
    assert_eq!(
        lines[1].text.as_str().find(NodeStatus::Running.letter()),
        Some(1)
    );
}

/// A policy with a doubtful file.
struct Doubtful;

impl AnyPolicy for Doubtful {
    fn reset(&mut self) {}

    fn warnings(&self, _cell: &Cell) -> Vec<String> {
        vec!["row 7 is never reached".to_owned()]
    }

    fn decide(&mut self, _: &Observation<'_>, _: &mut Job, _: &mut Output) {}

    fn phase(&self) -> Text<32> {
        Text::EMPTY
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        Vec::new()
    }

    fn statuses(&self, _graph: usize, _out: &mut Vec<NodeStatus>) {}

    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    fn restore(&mut self, _bytes: &[u8]) -> Result<(), bincode::Error> {
        Ok(())
    }

    fn reconcile(&mut self, _: &Observation<'_>, _: &mut Job, _: &mut Output) {}
}

#[test]
fn a_warning_about_a_file_is_told_at_the_start_and_not_after_each_kill() {
    let task = || {
        let cell = load("franka-pyramid");
        Task::new(&cell, "doubtful", GRIP_FORCE_N, Box::new(Doubtful))
    };
    let mut bench = Bench::of(task());
    bench.decide();
    assert_eq!(bench.count("[warning] row 7 is never reached"), 1);
    bench.decide();
    assert_eq!(bench.count("[warning]"), 0);
    let record = bench.task.checkpoint();
    bench.task = task();
    bench.task.restore(&record).unwrap();
    bench.decide();
    assert_eq!(bench.count("[warning]"), 0);
}

#[test]
fn a_key_of_a_blackboard_is_told_when_its_value_is_new_and_not_when_it_is_a_quantity() {
    let mut board = Board::new();
    let text = |text: &str| Value::Text(Str::new(text).unwrap());
    let owner = board.declare("owner", ValueType::Text, Some(text("")));
    let height = board.declare("height", ValueType::Number, Some(Value::Number(0.0)));
    let (owner, height) = (owner.unwrap(), height.unwrap());
    let mut watch = KeyWatch::default();
    let mut told = |board: &Board| {
        let mut out = Output::default();
        out.begin();
        watch.changes(board, "shared", 2, &mut out);
        let mut lines = Vec::new();
        out.finish(1, &mut Decision::zeroed(), &mut lines);
        let said = lines.iter().map(|line| (line.graph, line.text.to_string()));
        said.collect::<Vec<_>>()
    };
    assert_eq!(told(&board), [], "a default is not news");
    assert!(board.set(owner, text("left")) && board.set(height, Value::Number(0.3)));
    assert_eq!(told(&board), [(2, "shared.owner='left'".to_owned())]);
    assert_eq!(told(&board), []);
    assert!(board.set(owner, text("")));
    assert_eq!(told(&board), [(2, "shared.owner=''".to_owned())]);
}
