//! Breakpoints: names of nodes, states and guards at which the task requests a pause from
//! physics.

use behavior::{Graph, NodeStatus};
use cell_model::runs::phase_name;
use ipc_types::trace::TraceKind;
use ipc_types::{BreakName, Decision, OperatorPanel};
use serde::{Deserialize, Serialize};

use crate::output::TraceLineText;

/// The breakpoint that was reached last.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Breakpoints {
    tick: u64,
    name: String,
}

/// What happened in one decision.
pub(crate) struct Happened<'a> {
    pub(crate) graphs: &'a [Graph],
    pub(crate) lines: &'a [TraceLineText],
    /// The phase, where it was entered in this decision.
    pub(crate) entered: Option<&'a str>,
}

impl Breakpoints {
    /// Finds out whether one of the panel's breakpoints is reached at `tick`, and writes the
    /// newest one into the decision.
    pub(crate) fn update(
        &mut self,
        panel: &OperatorPanel,
        tick: u64,
        happened: &Happened<'_>,
        decision: &mut Decision,
    ) {
        // The panel lists names, not indices: a name keeps its meaning when the file of a
        // policy was edited and the task restarted.
        let mut names = panel.breaks().iter().map(BreakName::as_str);
        if let Some(name) = names.find(|name| happened.is_at(name)) {
            self.tick = tick;
            name.clone_into(&mut self.name);
        }
        // Written with every decision, not only when it is reached: a reader that missed the
        // decision in between still finds the last breakpoint (ADR 0001).
        decision.break_tick = self.tick;
        decision.break_name = BreakName::new(&self.name);
    }
}

impl Happened<'_> {
    fn is_at(&self, name: &str) -> bool {
        self.entered == Some(name) || self.lines.iter().any(|line| self.reaches(line, name))
    }

    /// Whether the node started, or started and ended within one tick, or the guard was
    /// evaluated.
    fn reaches(&self, line: &TraceLineText, name: &str) -> bool {
        match line.kind {
            TraceKind::Status => {
                // A node that already ran does not count: the breakpoint would pause again on
                // each step while the node continues to run.
                let ran = line.from == NodeStatus::Running as u32;
                let runs = line.to != NodeStatus::Invalid as u32;
                !ran && runs && self.is_node(line, name)
            }
            TraceKind::Guard => line.text.as_str() == name || self.is_node(line, name),
            _ => false,
        }
    }

    fn is_node(&self, line: &TraceLineText, name: &str) -> bool {
        let graph = self.graphs.get(line.graph);
        let node = graph.and_then(|graph| graph.nodes.get(line.node));
        graph.zip(node).is_some_and(|(graph, node)| {
            node.id == name
                || node.name == name
                // A phase may be named with its graph, as scripts and the summary of a run name
                // it.
                || phase_name::alike(&[name], &[&graph.name, &node.name])
        })
    }
}

#[cfg(test)]
mod tests {
    use ipc_types::{Text, Wire as _};

    use super::*;

    fn panel(name: &str) -> OperatorPanel {
        let mut panel = OperatorPanel::zeroed();
        panel.break_count = 1;
        panel.breaks[0] = Text::new(name);
        panel
    }

    fn at(name: &str, lines: &[TraceLineText], entered: Option<&str>) -> (u64, String) {
        let mut decision = Decision::zeroed();
        let happened = Happened {
            graphs: &[],
            lines,
            entered,
        };
        Breakpoints::default().update(&panel(name), 70, &happened, &mut decision);
        (decision.break_tick, decision.break_name.as_str().to_owned())
    }

    #[test]
    fn a_state_is_reached_when_it_is_entered_and_not_while_it_lasts() {
        assert_eq!(at("LIFT", &[], Some("LIFT")), (70, "LIFT".to_owned()));
        assert_eq!(at("LIFT", &[], Some("LOWER")).0, 0);
        assert_eq!(at("LIFT", &[], None).0, 0);
    }

    #[test]
    fn a_guard_is_reached_whatever_it_answers() {
        let mut out = crate::output::Output::default();
        out.begin();
        out.guard((0, 0), "attached", false);
        let (mut decision, mut lines) = (Decision::zeroed(), Vec::new());
        out.finish(1, &mut decision, &mut lines);
        assert_eq!(at("attached", &lines, None).0, 70);
        assert_eq!(at("detached", &lines, None).0, 0);
    }
}
