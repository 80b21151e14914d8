//! Script lines about processes: the launcher acts, then tells physics.

use cell_model::cells::script::{ScriptAction, ScriptLine};
use ipc_types::topic::Process;

/// What to do to processes now.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FaultStep {
    /// SIGKILL and start again.
    Kill(Process),
    /// SIGTERM and start again, with another policy.
    Restart(Process, Option<String>),
    /// What a line does to the machine.
    Disturb(ScriptAction),
    /// SIGSTOP.
    Freeze(Process),
    /// SIGCONT, if it is still this generation.
    Thaw(Process, u32),
    /// Tell physics that the launcher acted on this line.
    Tell(u32),
}

/// Carries out the lines for the launcher, each once.
#[derive(Debug)]
pub(crate) struct Faults {
    lines: Vec<ScriptLine>,
    processes: Vec<Process>,
    acted: Vec<u32>,
    /// Line and the generations that have to be gone before physics is told.
    dying: Option<(u32, Vec<(Process, u32)>)>,
    /// Until when (ns) which generation is frozen.
    frozen: Vec<(u64, Process, u32)>,
    /// Line that pauses simulated time, and until when (ns).
    pause: Option<(u32, u64)>,
}

impl Faults {
    pub(crate) fn new(lines: &[ScriptLine], processes: &[Process]) -> Self {
        Self {
            lines: lines.to_vec(),
            processes: processes.to_vec(),
            acted: Vec::new(),
            dying: None,
            frozen: Vec::new(),
            pause: None,
        }
    }

    /// Steps that are due at `now` (ns), with physics waiting at script line `line`
    /// (0: none); `generation` says which start of a process runs, if any.
    pub(crate) fn poll(
        &mut self,
        now: u64,
        line: u32,
        generation: impl Fn(Process) -> Option<u32>,
    ) -> Vec<FaultStep> {
        let mut steps = self.thaw(now);
        if line != 0 && self.dying.is_none() {
            self.act(now, line, &generation, &mut steps);
        }
        let gone =
            |(process, old): &(Process, u32)| generation(*process).is_none_or(|now| now > *old);
        if self
            .dying
            .as_ref()
            .is_some_and(|(_, targets)| targets.iter().all(gone))
            && let Some((line, _)) = self.dying.take()
        {
            steps.push(FaultStep::Tell(line));
        }
        steps
    }

    fn thaw(&mut self, now: u64) -> Vec<FaultStep> {
        let (due, rest) = self.frozen.drain(..).partition(|(until, ..)| *until <= now);
        self.frozen = rest;
        let due: Vec<(u64, Process, u32)> = due;
        due.into_iter()
            .map(|(_, process, generation)| FaultStep::Thaw(process, generation))
            .collect()
    }

    fn act(
        &mut self,
        now: u64,
        line: u32,
        generation: &impl Fn(Process) -> Option<u32>,
        steps: &mut Vec<FaultStep>,
    ) {
        let is_paused = |(of, until): (u32, u64)| of == line && now < until;
        if self.pause.is_some_and(is_paused) {
            return;
        }
        // A physics that resumes from an earlier state waits at the same line again; its effect
        // must not be repeated.
        if self.acted.contains(&line) {
            steps.push(FaultStep::Tell(line));
            return;
        }
        self.acted.push(line);
        let action = self.lines.get(line as usize - 1).map(|l| l.action.clone());
        match action {
            Some(ScriptAction::Kill { process }) => {
                self.end(line, &process, generation, steps, FaultStep::Kill);
            }
            Some(ScriptAction::Restart { process, policy }) => {
                let restart = |p| FaultStep::Restart(p, policy.clone());
                self.end(line, &process, generation, steps, restart);
            }
            Some(ScriptAction::Pause { for_s: Some(for_s) }) => {
                // By the clock of the launcher: no simulated time passes in a pause.
                self.pause = Some((line, now + nanos(for_s)));
            }
            Some(ScriptAction::Stop { process, for_s }) => {
                for target in self.named(&process) {
                    steps.push(FaultStep::Freeze(target));
                    if let Some(generation) = generation(target) {
                        self.frozen.push((now + nanos(for_s), target, generation));
                    }
                }
                steps.push(FaultStep::Tell(line));
            }
            Some(action) => {
                steps.extend([FaultStep::Disturb(action), FaultStep::Tell(line)]);
            }
            None => steps.push(FaultStep::Tell(line)),
        }
    }

    /// Ends the processes that `line` names; physics is told when they are gone.
    fn end(
        &mut self,
        line: u32,
        process: &str,
        generation: &impl Fn(Process) -> Option<u32>,
        steps: &mut Vec<FaultStep>,
        step: impl Fn(Process) -> FaultStep,
    ) {
        let targets = self.named(process);
        steps.extend(targets.iter().map(|target| step(*target)));
        let running = |target: &Process| Some((*target, generation(*target)?));
        self.dying = Some((line, targets.iter().filter_map(running).collect()));
    }

    fn named(&self, word: &str) -> Vec<Process> {
        named(&self.processes, word)
    }
}

/// The processes a word means: `controller` is all of them.
pub(crate) fn named(processes: &[Process], word: &str) -> Vec<Process> {
    let means = |p: &&Process| {
        p.name() == word || (word == "controller" && matches!(p, Process::Controller(_)))
    };
    processes.iter().filter(means).copied().collect()
}

/// Nanoseconds of a time of a script (s).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a script allows 0.001 to 3600 s"
)]
pub(crate) fn nanos(seconds: f64) -> u64 {
    (seconds * 1.0e9) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::topic::Process::{Controller, Monitor, Physics, Task};

    const SCRIPT: &str = r#"{"at_s": 1, "do": "kill", "process": "task"}
{"at_s": 2, "do": "stop", "process": "controller", "for_s": 0.5}
{"at_s": 3, "do": "pause", "for_s": 0.5}
{"at_s": 4, "do": "restart", "process": "task", "policy": "fsm"}
{"at_s": 5, "do": "fill", "for_s": 1}"#;

    fn faults() -> Faults {
        let lines = cell_model::cells::script::parse(SCRIPT, "s").unwrap();
        Faults::new(&lines, &[Physics, Controller(0), Task, Monitor])
    }

    #[test]
    fn physics_is_told_of_a_kill_only_when_the_process_is_gone() {
        let mut faults = faults();
        assert_eq!(faults.poll(0, 1, |_| Some(1)), [FaultStep::Kill(Task)]);
        assert_eq!(faults.poll(1, 1, |_| Some(1)), []);
        assert_eq!(faults.poll(2, 1, |_| None), [FaultStep::Tell(1)]);
        assert_eq!(faults.poll(3, 0, |_| Some(2)), []);
    }

    #[test]
    fn a_line_is_acted_on_once_even_for_a_new_physics() {
        let mut faults = faults();
        faults.poll(0, 1, |_| None);
        assert_eq!(faults.poll(9, 1, |_| Some(2)), [FaultStep::Tell(1)]);
    }

    #[test]
    fn a_pause_ends_after_its_time_also_for_a_new_physics() {
        let mut faults = faults();
        assert_eq!(faults.poll(0, 3, |_| Some(1)), []);
        assert_eq!(faults.poll(499_999_999, 3, |_| Some(2)), []);
        assert_eq!(
            faults.poll(500_000_000, 3, |_| Some(2)),
            [FaultStep::Tell(3)]
        );
    }

    #[test]
    fn a_task_is_restarted_with_another_policy_and_the_machine_is_disturbed() {
        let mut faults = faults();
        let restart = FaultStep::Restart(Task, Some("fsm".to_owned()));
        assert_eq!(faults.poll(0, 4, |_| Some(1)), [restart]);
        assert_eq!(faults.poll(1, 4, |_| Some(2)), [FaultStep::Tell(4)]);
        let fill = FaultStep::Disturb(ScriptAction::Fill { for_s: 1.0 });
        assert_eq!(faults.poll(2, 5, |_| Some(2)), [fill, FaultStep::Tell(5)]);
    }

    #[test]
    fn a_frozen_process_is_thawed_after_its_time() {
        let mut faults = faults();
        assert_eq!(
            faults.poll(0, 2, |_| Some(4)),
            [FaultStep::Freeze(Controller(0)), FaultStep::Tell(2)]
        );
        assert_eq!(faults.poll(499_999_999, 0, |_| Some(4)), []);
        assert_eq!(
            faults.poll(500_000_000, 0, |_| Some(4)),
            [FaultStep::Thaw(Controller(0), 4)]
        );
    }
}
