//! What a cell has reached.

use cell_run::summary::{RunFacts, RunOutcome, RunSummary};
use ipc_types::topic::Process;
use ipc_types::world::FLAG_ENDING;
use ipc_types::{Decision, Wire};

use super::LiveCell;
use crate::run::plan::Scene;

impl LiveCell {
    /// Summary of the run until `now` (ns); `None` where physics never ran.
    pub(super) fn summary(&self, now: u64) -> Option<RunSummary> {
        let (watch, supervisor) = (self.watch(), self.cell.supervisor());
        let state = watch.state()?;
        let plan = self.plan();
        let facts = RunFacts {
            demo: &plan.spec.demo,
            policy: &plan.spec.policy,
            seed: plan.spec.seed,
            objects: &plan.objects,
            wall_time_s: now.saturating_sub(self.started_ns) as f64 * 1.0e-9,
            task_restarts: supervisor.restarts(Process::Task),
            missed_cycles: watch.missed_cycles(),
        };
        let none = Decision::zeroed();
        let decision = watch.decision().unwrap_or(&none);
        let mut summary = RunSummary::new(&facts, state, decision);
        summary.faults = watch.faults().to_vec();
        // The outcome of a task that has not ended is `Timeout`, whether its time is over or not.
        let is_over = state.has(FLAG_ENDING) || summary.outcome != RunOutcome::Timeout;
        if !is_over {
            summary.outcome = RunOutcome::Stopped;
        }
        let restarts = self.processes.iter().map(|process| {
            let count = supervisor.restarts(*process);
            (process.name(), count)
        });
        summary.restarts = restarts.filter(|(_, count)| *count > 0).collect();
        Some(summary)
    }

    /// Names of the objects in place.
    pub fn names(&self, decision: &Decision) -> Vec<String> {
        let count = (decision.placed_count as usize).min(decision.placed.len());
        let objects = &self.plan().objects;
        let name = |index: &u32| objects.get(*index as usize).cloned();
        decision.placed[..count].iter().filter_map(name).collect()
    }

    /// Starts to set the same scene up again with the next seed; not while another scene is
    /// being planned.
    pub fn play_next_seed(&mut self) -> bool {
        let plan = &self.cell.machine().plan;
        self.planning.start(plan, Scene::NextSeed).is_ok()
    }
}
