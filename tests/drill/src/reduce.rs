//! Makes a failing plan small: fewer faults, a shorter run.

use crate::batch::examine;
use crate::check::Failed;
use crate::plan::Plan;

/// Runs that a reduction may take.
const RUNS: usize = 300;

/// The smallest plan found that breaks the same invariant as `plan`, how, and the runs it took.
pub fn reduce(plan: &Plan, failed: &Failed) -> (Plan, Failed, usize) {
    let mut small = Small {
        plan: plan.clone(),
        failed: failed.clone(),
        runs: 0,
    };
    // Nothing after the failure was needed for it.
    small.shorten();
    let mut part = small.plan.faults.len().div_ceil(2);
    while part > 0 {
        small.without_each(part);
        part = if part == 1 { 0 } else { part.div_ceil(2) };
    }
    let calm = |plan: &Plan, people: bool, script: bool| Plan {
        people: if people { plan.people.clone() } else { vec![] },
        script: if script { plan.script.clone() } else { vec![] },
        ..plan.clone()
    };
    small.accept(calm(&small.plan, false, true));
    small.accept(calm(&small.plan, true, false));
    small.shorten();
    (small.plan, small.failed, small.runs)
}

struct Small {
    plan: Plan,
    failed: Failed,
    runs: usize,
}

impl Small {
    /// Tries to leave out each part of `length` faults.
    fn without_each(&mut self, length: usize) {
        let mut at = 0;
        while at < self.plan.faults.len() {
            let mut plan = self.plan.clone();
            let end = (at + length).min(plan.faults.len());
            plan.faults.drain(at..end);
            if !self.accept(plan) {
                at += length;
            }
        }
    }

    fn shorten(&mut self) {
        let horizon_ms = self.failed.at_us / 1000 + 1;
        if horizon_ms < self.plan.horizon_ms {
            let plan = self.plan.clone();
            self.accept(Plan { horizon_ms, ..plan });
        }
    }

    /// Takes `plan` if it breaks the same invariant.
    fn accept(&mut self, plan: Plan) -> bool {
        if self.runs == RUNS {
            return false;
        }
        self.runs += 1;
        let failed = examine(&plan).ok().and_then(|outcome| outcome.failed);
        let same = failed.filter(|failed| failed.invariant == self.failed.invariant);
        let is_same = same.is_some();
        if let Some(failed) = same {
            (self.plan, self.failed) = (plan, failed);
        }
        is_same
    }
}
