//! The output of a policy in one decision, and its conversion to a message.

use behavior::NodeStatus;
use ipc_types::decision::{GoalKind, Outcome, WAIT_BYTES};
use ipc_types::trace::{LINE_BYTES, TraceEvent, TraceKind};
use ipc_types::{ArmGoal, Decision, GripperGoal, MAX_ARMS, MAX_JOINTS, Pose, Text, Wire};

use crate::goal_book::{GoalBook, PreviousGoal};
use crate::reason::Reason;

/// Lines of one decision for which memory is reserved.
// More than ordinary decisions write, so that they do not allocate; longer ones do, and
// lose nothing.
pub const ROOM_FOR_LINES: usize = 512;

/// One line of the task's trace, see [`ipc_types::TraceLine`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceLineText {
    /// What kind of line it is.
    pub kind: TraceKind,
    /// Which of the policy's graphs.
    pub graph: usize,
    /// Which node of it.
    pub node: usize,
    /// By kind: a status, a node.
    pub from: u32,
    /// By kind: a status, a node, an answer.
    pub to: u32,
    /// What the line reports, for programs.
    pub event: TraceEvent,
    /// The line, cut to what a message carries.
    pub text: Text<LINE_BYTES>,
}

/// What one arm shall do until the next decision. The default has the same meaning as
/// silence: hold, and keep the gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmIntent {
    /// What the arm shall do.
    pub kind: GoalKind,
    /// What the gripper shall do.
    pub gripper: GripperGoal,
    /// A new key is a new goal with a new number; the same key moves the target
    /// of the goal under way.
    pub key: u64,
    /// Which controller moves the arm: 0 for RMPflow, others as the controller
    /// program numbers them.
    pub selector: u32,
    /// TCP in the world frame, for [`GoalKind::Pose`].
    pub target: Pose,
    /// Joint configuration that the motion prefers, or its goal for [`GoalKind::Joints`]
    /// (rad or m).
    pub posture: Option<[f64; MAX_JOINTS]>,
    /// Force per finger when closing (N).
    pub grip_force: f64,
    /// Distance of the fingers when they open (m); 0 for as far as they open.
    pub open_width: f64,
    /// Direction of the last part of the approach times its length (m), world
    /// frame; zero for a straight attraction.
    pub approach: [f64; 3],
    /// Width of the approach corridor (standard deviation, m).
    pub approach_std_dev: f64,
    /// Fixtures that count as obstacles, see [`ArmGoal::obstacle_mask`].
    pub obstacle_mask: u64,
    /// Objects that count as obstacles, see [`ArmGoal::object_mask`].
    pub object_mask: u64,
}

impl Default for ArmIntent {
    fn default() -> Self {
        Self {
            kind: GoalKind::Hold,
            gripper: GripperGoal::Keep,
            key: 0,
            selector: 0,
            target: Pose::IDENTITY,
            posture: None,
            grip_force: 0.0,
            open_width: 0.0,
            approach: [0.0; 3],
            approach_std_dev: 0.0,
            // All obstacles by default: a policy that forgets the mask avoids too much, not too
            // little.
            obstacle_mask: u64::MAX,
            object_mask: u64::MAX,
        }
    }
}

/// Collects one decision. Emptied before every decision, so an arm the policy
/// does not command holds.
#[derive(Debug, Default)]
pub struct Output {
    intents: [ArmIntent; MAX_ARMS],
    lines: Vec<TraceLineText>,
    book: GoalBook,
    /// See [`Output::message`].
    message: Option<String>,
    /// A fault was reported in this decision.
    has_fault: bool,
    /// Name of the phase, for people and scripts.
    pub phase: Text<32>,
    /// Whether the job runs, is done or has failed.
    pub outcome: Outcome,
    /// Stable name of the reason, empty if none.
    pub reason: Text<{ Reason::MAX_BYTES }>,
    /// See [`Decision::wait`].
    pub wait: Text<WAIT_BYTES>,
}

impl Output {
    /// Empties everything but the memory of the previous decisions.
    pub fn begin(&mut self) {
        // Intents of the decision before are cleared: an arm that this decision does not
        // mention has to hold, not to repeat its last motion.
        self.intents = [ArmIntent::default(); MAX_ARMS];
        self.lines.clear();
        // `finish` moves the lines out; without room made here a decision would allocate.
        self.lines.reserve(ROOM_FOR_LINES);
        self.has_fault = false;
        self.phase = Text::EMPTY;
        self.outcome = Outcome::Running;
        self.reason = Text::EMPTY;
        self.wait = Text::EMPTY;
    }

    /// Sets what `arm` shall do; an arm that does not exist is ignored.
    pub fn arm(&mut self, arm: usize, intent: ArmIntent) {
        if let Some(slot) = self.intents.get_mut(arm) {
            *slot = intent;
        }
    }

    /// The goal of `arm` in the previous decision.
    pub fn previous(&self, arm: usize) -> Option<PreviousGoal> {
        self.book.previous(arm)
    }

    /// Adds a log line.
    pub fn log(&mut self, line: std::fmt::Arguments<'_>) {
        self.push(TraceKind::Log, TraceEvent::None, line);
    }

    /// Adds a log line about an event that programs receive, too.
    pub fn event(&mut self, event: TraceEvent, line: std::fmt::Arguments<'_>) {
        // The sentence is kept in full: the trace has only lines of at most `LINE_BYTES`,
        // and the summary of a run gives the whole reason.
        if event == TraceEvent::Fault {
            self.message = Some(without_mark(&line.to_string()).to_owned());
            self.has_fault = true;
        }
        self.push(TraceKind::Log, event, line);
    }

    /// Adds a line about a phase that ended.
    pub fn transition(&mut self, line: std::fmt::Arguments<'_>) {
        self.push(TraceKind::Transition, TraceEvent::None, line);
    }

    /// Adds a line about the task itself: started, paused, resumed.
    pub fn lifecycle(&mut self, event: TraceEvent, line: std::fmt::Arguments<'_>) {
        self.push(TraceKind::Lifecycle, event, line);
    }

    /// Adds that a node of one of the policy's graphs changed its status, and why.
    pub fn status(
        &mut self,
        (graph, node): (usize, usize),
        from: NodeStatus,
        to: NodeStatus,
        reason: &str,
    ) {
        self.lines.push(TraceLineText {
            kind: TraceKind::Status,
            graph,
            node,
            from: from as u32,
            to: to as u32,
            event: TraceEvent::None,
            text: Text::new(reason),
        });
    }

    /// Adds the result of a guard.
    pub fn guard(&mut self, (graph, node): (usize, usize), name: &str, holds: bool) {
        self.lines.push(TraceLineText {
            kind: TraceKind::Guard,
            graph,
            node,
            from: 0,
            to: u32::from(holds),
            event: TraceEvent::None,
            text: Text::new(name),
        });
    }

    /// Adds the new value of a blackboard key.
    pub fn key(&mut self, graph: usize, scope: &str, key: &str, value: &dyn std::fmt::Display) {
        self.push(
            TraceKind::Key,
            TraceEvent::None,
            format_args!("{scope}.{key}={value}"),
        );
        if let Some(line) = self.lines.last_mut() {
            line.graph = graph;
        }
    }

    /// The newest fault as a sentence, without its mark and in full.
    pub(crate) fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Called when the newest fault is not the reason of the failure, or the job starts again.
    pub(crate) fn forget_message(&mut self) {
        self.message = None;
    }

    /// Whether a fault was reported in this decision.
    pub(crate) fn has_fault(&self) -> bool {
        self.has_fault
    }

    fn push(&mut self, kind: TraceKind, event: TraceEvent, line: std::fmt::Arguments<'_>) {
        // Formatted into the line directly: ordinary lines do not allocate.
        if event != TraceEvent::Fault {
            self.add(kind, event, Text::format(line));
            return;
        }
        self.push_parts(kind, event, &line.to_string());
    }

    /// A fault names a file, a line and the known names, and often ends with the advice. It is
    /// therefore continued on further lines where other lines are cut.
    fn push_parts(&mut self, kind: TraceKind, event: TraceEvent, text: &str) {
        let (first, mut rest) = split_at_most(text, LINE_BYTES);
        self.add(kind, event, Text::new(first));
        while !rest.is_empty() {
            let (part, more) = split_at_most(rest, LINE_BYTES - CONTINUED.len());
            // One event is marked once on the page.
            let line = Text::format(format_args!("{CONTINUED}{part}"));
            self.add(kind, TraceEvent::None, line);
            rest = more;
        }
    }

    fn add(&mut self, kind: TraceKind, event: TraceEvent, text: Text<LINE_BYTES>) {
        self.lines.push(TraceLineText {
            kind,
            graph: 0,
            node: 0,
            from: 0,
            to: 0,
            event,
            text,
        });
    }

    pub(crate) fn book(&self) -> &GoalBook {
        &self.book
    }

    pub(crate) fn book_mut(&mut self) -> &mut GoalBook {
        &mut self.book
    }

    /// Writes the goals and their report into `decision`, and moves the lines to `trace`.
    pub fn finish(
        &mut self,
        arm_count: usize,
        decision: &mut Decision,
        trace: &mut Vec<TraceLineText>,
    ) {
        // The message has room for `MAX_ARMS`; slots of other arms stay zero, so that equal
        // decisions have equal bytes, which a replay compares.
        let arm_count = arm_count.min(MAX_ARMS);
        decision.goals = [ArmGoal::zeroed(); MAX_ARMS];
        for (arm, intent) in self.intents.iter().take(arm_count).enumerate() {
            let mut goal = intent.to_goal();
            self.book.publish(arm, intent.key, &mut goal);
            if let Some(slot) = decision.goals.get_mut(arm) {
                *slot = goal;
            }
        }
        decision.arm_count = u32::try_from(arm_count).unwrap_or(0);
        decision.outcome = self.outcome.code();
        decision.phase = self.phase;
        decision.reason = self.reason;
        decision.wait = self.wait;
        trace.append(&mut self.lines);
    }
}

impl ArmIntent {
    /// The TCP moves to `target`, world frame. The same `key` moves the target of the goal
    /// in progress, another key is a new goal.
    pub fn pose(key: u64, target: Pose) -> Self {
        Self {
            kind: GoalKind::Pose,
            key,
            target,
            ..Self::default()
        }
    }

    fn to_goal(self) -> ArmGoal {
        ArmGoal {
            kind: self.kind.code(),
            gripper: self.gripper.code(),
            selector: self.selector,
            has_posture: u32::from(self.posture.is_some()),
            target: self.target,
            posture: self.posture.unwrap_or_default(),
            grip_force: self.grip_force,
            open_width: self.open_width,
            approach: self.approach,
            approach_std_dev: self.approach_std_dev,
            obstacle_mask: self.obstacle_mask,
            object_mask: self.object_mask,
            ..ArmGoal::zeroed()
        }
    }
}

/// Prefix of a line that continues the line before.
pub const CONTINUED: &str = "  ... ";

/// `text` without a mark such as `[fault] `.
fn without_mark(text: &str) -> &str {
    let mark = text
        .strip_prefix('[')
        .and_then(|rest| rest.split_once("] "));
    mark.map_or(text, |(_, sentence)| sentence)
}

/// The first part of `text`, of at most `bytes` bytes, and the rest.
fn split_at_most(text: &str, bytes: usize) -> (&str, &str) {
    // A cut within a character would panic; the search goes back to a character boundary.
    let mut ends = (0..=bytes.min(text.len())).rev();
    let end = ends.find(|end| text.is_char_boundary(*end));
    text.split_at(end.unwrap_or(text.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_nobody_speaks_for_holds_and_keeps_its_gripper() {
        let mut out = Output::default();
        out.begin();
        let mut decision = Decision::zeroed();
        out.finish(2, &mut decision, &mut Vec::new());
        assert_eq!(decision.arm_count, 2);
        for goal in decision.goals {
            assert_eq!(
                (goal.kind, goal.gripper),
                (GoalKind::Hold.code(), GripperGoal::Keep.code())
            );
        }
        ipc_types::Validate::validate(&decision).unwrap();
    }

    #[test]
    fn a_long_line_is_cut_and_says_so() {
        let mut out = Output::default();
        out.log(format_args!("{}ß", "x".repeat(LINE_BYTES - 1)));
        out.log(format_args!("[decide] -> stack {}", "red_cube"));
        let cut = format!("{}…", "x".repeat(LINE_BYTES - 3));
        assert_eq!(out.lines[0].text.as_str(), cut);
        assert_eq!(out.lines[1].text.as_str(), "[decide] -> stack red_cube");
    }

    #[test]
    fn a_long_fault_is_continued_and_told_in_full() {
        let mut out = Output::default();
        let sentence = format!("{}ß: unknown object 'redcube'", "x/".repeat(LINE_BYTES));
        out.event(TraceEvent::Fault, format_args!("[fault] {sentence}"));
        assert_eq!(out.message(), Some(sentence.as_str()));
        assert_eq!(out.lines[0].event, TraceEvent::Fault);
        let parts = out.lines.iter().map(|line| line.text.as_str());
        let parts = parts.map(|text| text.strip_prefix(CONTINUED).unwrap_or(text));
        assert_eq!(parts.collect::<String>(), format!("[fault] {sentence}"));
        assert!(
            out.lines[1..]
                .iter()
                .all(|line| line.event == TraceEvent::None)
        );
    }
}
