//! One run of a plan: the events in the order of their virtual times, each seen by the checks.

use std::collections::BTreeMap;

use cell_bus::Disturbance;
use ipc_types::topic::Process;
use supervisor::run::supervisor_loop::{SupervisorLoop, Terms, Verdict};
use supervisor::supervision::Rules;

use crate::check::{Checks, Failed, Moment, Seen};
use crate::coverage::Coverage;
use crate::model::{Launcher, Model, News, Shared};
use crate::observer::Observer;
use crate::people::People;
use crate::plan::{Fault, MS, Plan, Timed, noise, process};

/// Time between two turns of the launcher (ns).
const LAUNCHER_NS: u64 = 5 * MS;

/// What a run showed.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The first invariant that did not hold.
    pub failed: Option<Failed>,
    /// Simulated time (ms): that of the run, or that of its ticks where they are more.
    pub simulated_ms: u64,
    /// Virtual time (ms).
    pub ran_ms: u64,
    /// Hash over everything the checks saw.
    pub digest: u64,
    /// Hashes of states, by tick.
    pub hashes: Vec<(u64, u64)>,
    /// Hashes of what decisions say, by tick.
    pub decisions: BTreeMap<u64, u64>,
    /// By kind: faults that had a process or a file to act on.
    pub effective: [u32; Fault::KINDS.len()],
    /// The states that were reached.
    pub coverage: Coverage,
    /// The last events, for people.
    pub log: Vec<String>,
}

impl Outcome {
    /// Frees what only the comparison with another run needs: a batch keeps all outcomes.
    pub(crate) fn forget_run(&mut self) {
        self.hashes = Vec::new();
        self.decisions = BTreeMap::new();
        self.log = Vec::new();
    }
}

/// Runs `plan` to its end, or to the first invariant that does not hold.
///
/// # Errors
/// In words, where the plan has no scene: the generator is wrong.
pub fn run(plan: &Plan) -> Result<Outcome, String> {
    // From here on no line of a process goes to stderr.
    cell_worker::keep_lines();
    let model = Model::new(plan)?;
    let launcher = Launcher::new(&model).map_err(|error| error.to_string())?;
    let observer = Observer::new(&model, plan).map_err(|error| error.to_string())?;
    let checks = Checks::of(plan, &model.borrow());
    let mut run = Run {
        cell: SupervisorLoop::new(launcher, terms(plan, &model)),
        checks,
        observer,
        outcome: Outcome::default(),
        due: plan.faults.clone(),
        people: People::new(plan, &model).map_err(|error| error.to_string())?,
        has_finished: false,
        launcher_ns: 0,
        turns: 0,
        plan,
        model,
    };
    run.due.sort_by_key(|timed| timed.at_us);
    run.due.reverse();
    run.finish();
    Ok(run.outcome)
}

fn terms(plan: &Plan, model: &Shared) -> Terms {
    let model = model.borrow();
    Terms {
        demo: plan.demo.clone(),
        processes: model.processes(),
        rules: Rules {
            watchdog: true,
            lockstep: plan.lockstep,
            python_task: false,
        },
        script: model.spec.script.clone(),
        gives_start: true,
        has_clients: false,
    }
}

struct Run<'a> {
    plan: &'a Plan,
    model: Shared,
    cell: SupervisorLoop<Launcher>,
    observer: Observer,
    checks: Checks,
    outcome: Outcome,
    /// Faults that have not happened; the next one last.
    due: Vec<Timed>,
    people: People,
    /// The job is done, or its time is over.
    has_finished: bool,
    launcher_ns: u64,
    turns: u64,
}

impl Run<'_> {
    fn finish(&mut self) {
        let end_ns = self.plan.horizon_ms * MS;
        let mut now_ns = 0;
        while now_ns < end_ns && self.outcome.failed.is_none() && !self.has_finished {
            let fault_ns = self.due.last().map_or(u64::MAX, |timed| timed.at_us * 1000);
            let next = self.model.borrow().next();
            let process_ns = next.map_or(u64::MAX, |(due_ns, _)| due_ns);
            now_ns = now_ns.max(fault_ns.min(self.launcher_ns).min(process_ns));
            match next {
                _ if fault_ns <= now_ns => self.fault(now_ns),
                _ if self.launcher_ns <= now_ns => self.launch(now_ns),
                Some((_, process)) => {
                    let has_worked = self.model.borrow_mut().turn(now_ns, process);
                    if has_worked {
                        self.observe(now_ns, Some(process));
                    }
                }
                None => {}
            }
        }
        self.outcome.ran_ms = now_ns.min(end_ns) / MS;
        // Lockstep makes more ticks than real time.
        self.outcome.simulated_ms = self.outcome.ran_ms.max(self.checks.ticks());
        if self.outcome.failed.is_none() {
            self.outcome.failed = self.checks.end(now_ns);
        }
        self.outcome.digest = self.checks.result();
        self.outcome.hashes = self.checks.hashes().to_vec();
        self.outcome.decisions.clone_from(self.checks.decisions());
        self.outcome.log = self.checks.take_log();
        self.outcome.coverage = self.checks.take_coverage();
    }

    /// A turn of the launcher.
    fn launch(&mut self, now_ns: u64) {
        self.model.borrow().site.set_now_ns(now_ns);
        self.cell.look(now_ns);
        match self.cell.take_verdict() {
            Some(Verdict::GaveUp(failure)) => self.see(now_ns, Seen::GaveUp(&failure.message)),
            Some(Verdict::Finished) => self.has_finished = true,
            None => {}
        }
        self.cell.act(now_ns);
        if let Some((asked, reply)) = self.people.turn(now_ns) {
            let answered = |reply| Seen::Answered(&asked, reply);
            let seen = reply.as_deref().map_or(Seen::Asked(&asked), answered);
            self.see(now_ns, seen);
        }
        self.observe(now_ns, None);
        self.see(now_ns, Seen::Looked);
        self.turns += 1;
        // It sleeps for 5 ms after its work, and is woken late.
        let late_ns = noise(self.plan.seed, 2, self.turns) % 300_000;
        self.launcher_ns = now_ns + LAUNCHER_NS + late_ns;
    }

    fn fault(&mut self, now_ns: u64) {
        let Some(timed) = self.due.pop() else {
            return;
        };
        self.model.borrow().site.set_now_ns(now_ns);
        let is_effective = self.inject(now_ns, &timed.fault);
        self.outcome.effective[timed.fault.kind()] += u32::from(is_effective);
        if is_effective {
            self.see(now_ns, Seen::Fault(&timed.fault));
        }
        self.observe(now_ns, None);
    }

    /// Lets the fault happen; false where it has nothing to act on.
    fn inject(&mut self, now_ns: u64, fault: &Fault) -> bool {
        let arms = self.model.borrow().spec.arms;
        if let Fault::Restart { process: name } = fault {
            let of = process(name, arms);
            let of = of.filter(|of| self.model.borrow().exists(*of));
            if let Some(of) = of {
                self.cell.restart(now_ns, of);
            }
            return of.is_some();
        }
        let mut model = self.model.borrow_mut();
        let until = |ms: u64| now_ns + ms * MS;
        match fault {
            Fault::Kill {
                process: of,
                effect,
            } => process(of, arms).is_some_and(|of| model.kill(of, *effect)),
            Fault::Stop {
                process: of,
                for_ms,
            } => process(of, arms).is_some_and(|of| model.stop(of, until(*for_ms))),
            Fault::Starve {
                process: of,
                for_ms,
            } => process(of, arms).is_some_and(|of| model.starve(of, until(*for_ms))),
            Fault::Hang { process: of } => process(of, arms).is_some_and(|of| model.hang(of)),
            // See above: the launcher does it.
            Fault::Restart { .. } => false,
            Fault::Busy {
                process: of,
                for_ms,
                turn_us,
            } => process(of, arms)
                .is_some_and(|of| model.slow_down(of, turn_us * 1000, until(*for_ms))),
            Fault::FailedStart { process: of } => process(of, arms).is_some_and(|of| {
                model.fail_start(of);
                model.kill(of, None)
            }),
            Fault::SlowStart {
                process: of,
                for_ms,
            } => process(of, arms).is_some_and(|of| {
                model.slow_start(of, *for_ms);
                model.kill(of, None)
            }),
            Fault::Launcher { for_ms } => {
                self.launcher_ns = self.launcher_ns.max(until(*for_ms));
                true
            }
            Fault::Full { .. }
            | Fault::SlowDisk { .. }
            | Fault::DamageFile { .. }
            | Fault::CutWrite { .. }
            | Fault::Preempt { .. }
            | Fault::Damage { .. }
            | Fault::Repeat { .. }
            | Fault::Late { .. } => disturb(&mut model, arms, now_ns, fault),
        }
    }

    /// Shows the checks what happened, and what `process` sent.
    fn observe(&mut self, now_ns: u64, process: Option<Process>) {
        let news: Vec<News> = self.model.borrow_mut().take_news();
        for news in &news {
            let seen = match news {
                News::Disturbed(fault) => Seen::Fault(fault),
                _ => Seen::News(news),
            };
            self.see(now_ns, seen);
        }
        let Some(process) = process else {
            return;
        };
        let (checks, failed) = (&mut self.checks, &mut self.outcome.failed);
        self.observer.look(process, |seen| {
            let found = checks.see(&Moment { now_ns, seen });
            if failed.is_none() {
                *failed = found;
            }
        });
    }

    fn see(&mut self, now_ns: u64, seen: Seen<'_>) {
        let found = self.checks.see(&Moment { now_ns, seen });
        if self.outcome.failed.is_none() {
            self.outcome.failed = found;
        }
    }
}

/// Disturbs the disk, files, messages and turns; false where there is nothing to disturb.
fn disturb(model: &mut Model, arms: u8, now_ns: u64, fault: &Fault) -> bool {
    match fault {
        Fault::Full { for_ms } => {
            model.fill(now_ns + for_ms * MS);
            true
        }
        Fault::SlowDisk { for_ms, write_ms } => {
            model.slow_disk(*write_ms, now_ns + for_ms * MS);
            true
        }
        Fault::DamageFile { file, draw } => model.damage_file(file, *draw),
        Fault::CutWrite { steps } => {
            model.cut_write(*steps);
            model.exists(Process::Physics)
        }
        Fault::Preempt {
            process: of,
            for_ms,
            gap_us,
        } => process(of, arms)
            .is_some_and(|of| model.preempt(of, gap_us * 1000, now_ns + for_ms * MS)),
        Fault::Damage { topic, draw } => model.disturb(topic, Disturbance::Damage { draw: *draw }),
        Fault::Repeat {
            topic,
            after,
            count,
        } => {
            let (after, count) = (*after, *count);
            model.disturb(topic, Disturbance::Again { after, count })
        }
        Fault::Late { topic, after } => model.disturb(topic, Disturbance::Late { after: *after }),
        _ => false,
    }
}
