//! The lines of a script while it runs: which are due, and what was executed.
//!
//! A look in a tick costs the same whatever the number of lines, and a state that physics saves
//! has only what the lines changed: they are in the run file already.

use std::collections::{BTreeMap, BTreeSet};

use ipc_types::TICK_NS;
use serde::{Deserialize, Serialize};

use crate::cells::script_line::{ScriptAction, ScriptLine, Trigger};
use crate::runs::phase_name;

/// What a script has changed in a run: with its lines, this is the whole runner.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScriptProgress {
    /// Indices of lines that have fired.
    fired: BTreeSet<u32>,
    /// By index of a line `at_phase`: entries into its phase.
    entries: BTreeMap<u32, u32>,
    /// By index of such a line: the tick at which it is due.
    due: BTreeMap<u32, u64>,
    phase: String,
    phase_entry: u32,
}

/// Counts entries into phases, and finds the lines that are due.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScriptRunner {
    lines: Vec<ScriptLine>,
    progress: ScriptProgress,
    /// Lines that have not fired, by the tick at which they are due, where that is known.
    later: BTreeMap<u64, Vec<u32>>,
    /// Lines that are due and have not fired.
    ready: BTreeSet<u32>,
}

impl ScriptRunner {
    /// A runner for `lines`, before any of them has fired.
    pub fn new(lines: &[ScriptLine]) -> Self {
        let mut runner = Self {
            lines: lines.to_vec(),
            ..Self::default()
        };
        runner.restore(ScriptProgress::default());
        runner
    }

    /// What was executed until now.
    pub fn progress(&self) -> &ScriptProgress {
        &self.progress
    }

    /// Continues from `progress` of a runner for the same lines.
    pub fn restore(&mut self, progress: ScriptProgress) {
        self.later.clear();
        self.ready.clear();
        for (index, line) in (0..).zip(&self.lines) {
            let due = match line.trigger {
                Trigger::Time { at_s } => Some(ticks(at_s)),
                Trigger::Phase { .. } => progress.due.get(&index).copied(),
            };
            if let Some(due) = due.filter(|_| !progress.fired.contains(&index)) {
                self.later.entry(due).or_default().push(index);
            }
        }
        self.progress = progress;
    }

    /// Number of lines that have not fired.
    pub fn left(&self) -> u32 {
        let left = self.lines.len().saturating_sub(self.progress.fired.len());
        u32::try_from(left).unwrap_or(u32::MAX)
    }

    /// Records the phase and the count of entries of the newest decision, in a cell with these
    /// arms.
    pub fn observe(&mut self, tick: u64, phase: &str, phase_entry: u32, arms: &[String]) {
        let progress = &mut self.progress;
        // Phase and count are compared: a phase may be entered again from itself.
        if phase_entry == progress.phase_entry && phase == progress.phase {
            return;
        }
        phase.clone_into(&mut progress.phase);
        progress.phase_entry = phase_entry;
        for (index, line) in (0..).zip(&self.lines) {
            if let Trigger::Phase {
                at_phase,
                nth,
                after_s,
            } = &line.trigger
                && phase_name::is_same(at_phase, phase, arms)
            {
                let entries = progress.entries.entry(index).or_default();
                *entries += 1;
                // Exactly the nth: a later entry must not move the time again.
                if *entries == *nth {
                    let due = tick + ticks(*after_s);
                    progress.due.insert(index, due);
                    self.later.entry(due).or_default().push(index);
                }
            }
        }
    }

    /// The first line due at `tick` that has not fired, with its number from 1; it counts as
    /// fired from now on.
    pub fn next_due(&mut self, tick: u64) -> Option<(u32, ScriptAction)> {
        while let Some(entry) = self.later.first_entry()
            && *entry.key() <= tick
        {
            self.ready.extend(entry.remove());
        }
        let index = self.ready.pop_first()?;
        self.progress.fired.insert(index);
        let line = self.lines.get(usize::try_from(index).ok()?)?;
        Some((index.saturating_add(1), line.action.clone()))
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "parse allows 0 to 1e6 seconds only"
)]
fn ticks(seconds: f64) -> u64 {
    (seconds * 1.0e9 / TICK_NS as f64).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::script::{MAX_LINES, parse};

    #[test]
    fn a_line_fires_once_at_its_time_and_on_its_entry() {
        let text = r#"{"at_phase": "LIFT", "nth": 2, "do": "kill", "process": "task"}
{"at_s": 0.02, "do": "pause"}"#;
        let mut runner = ScriptRunner::new(&parse(text, "s").unwrap());
        assert_eq!(runner.left(), 2);
        assert_eq!(runner.next_due(19), None);
        assert_eq!(runner.next_due(20).map(|(n, _)| n), Some(2));
        assert_eq!(runner.next_due(21), None);
        runner.observe(30, "LIFT", 4, &[]);
        runner.observe(31, "LIFT", 4, &[]);
        assert_eq!(runner.next_due(31), None);
        runner.observe(40, "TRANSPORT", 5, &[]);
        runner.observe(50, "LIFT", 12, &[]);
        assert_eq!(runner.next_due(50).map(|(n, _)| n), Some(1));
        assert_eq!(runner.left(), 0);
    }

    #[test]
    fn of_several_lines_that_are_due_the_first_of_the_script_comes_first() {
        let text = "{\"at_s\": 0.002, \"do\": \"reset\"}\n{\"at_s\": 0.001, \"do\": \"pause\"}\n\
                    {\"at_s\": 0.009, \"do\": \"resume\"}";
        let mut runner = ScriptRunner::new(&parse(text, "s").unwrap());
        let mut next = |tick| runner.next_due(tick).map(|(number, _)| number);
        assert_eq!(
            [next(5), next(5), next(5), next(9)],
            [Some(1), Some(2), None, Some(3)]
        );
    }

    #[test]
    fn a_restored_runner_continues_where_the_saved_one_was() {
        let text = "{\"at_s\": 0.001, \"do\": \"pause\"}\n{\"at_s\": 0.005, \"do\": \"pause\"}\n\
                    {\"at_phase\": \"LIFT\", \"nth\": 2, \"after_s\": 0.01, \"do\": \"reset\"}\n\
                    {\"at_phase\": \"LIFT\", \"do\": \"resume\"}";
        let lines = parse(text, "s").unwrap();
        // All lines that fire, where the runner is saved and restored before tick `cut`.
        let fired = |cut: u64| {
            let (mut runner, mut fired) = (ScriptRunner::new(&lines), Vec::new());
            for tick in 0..30 {
                if tick == cut {
                    let saved = serde_json::to_string(runner.progress()).unwrap();
                    runner = ScriptRunner::new(&lines);
                    runner.restore(serde_json::from_str(&saved).unwrap());
                }
                runner.observe(tick, "LIFT", 1 + u32::from(tick >= 4), &[]);
                let due = runner.next_due(tick);
                fired.extend(due.map(|(number, _)| (tick, number, runner.left())));
            }
            fired
        };
        let whole = fired(u64::MAX);
        assert_eq!(whole, [(0, 4, 3), (1, 1, 2), (5, 2, 1), (14, 3, 0)]);
        for cut in 0..30 {
            assert_eq!(fired(cut), whole, "{cut}");
        }
    }

    #[test]
    fn lines_that_have_not_fired_are_no_state() {
        let lines = "{\"at_s\": 900, \"do\": \"drag\", \"object\": \"a\", \"to\": [1, 2, 3]}\n";
        let runner = ScriptRunner::new(&parse(&lines.repeat(MAX_LINES), "s").unwrap());
        let saved = serde_json::to_vec(runner.progress()).unwrap();
        assert!(saved.len() < 100, "{}", saved.len());
    }
}
