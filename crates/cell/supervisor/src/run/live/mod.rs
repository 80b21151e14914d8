//! A running cell: the supervisor's loop, the control socket and the files of the run.

mod os;
mod requests;
mod result;

use std::time::Duration;

use cell_rt::clock::monotonic_ns;
use cell_rt::priority::{LAUNCHER_PRIORITY, set_fifo, set_other};
use cell_rt::process::private_umask;
use cell_rt::signal::{install_stop_handler, stop_count};
use cell_run::message::Message;
use cell_run::python;
use cell_run::report;
use cell_run::script_report;
use cell_run::spec::{PageSecrets, RunSpec};
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;

use super::end::End;
use super::files::recording::RecordWatch;
use super::machine::Machine;
use super::plan::Plan;
use super::planning::Planning;
use super::supervisor_loop::{SupervisorLoop, Terms, Verdict};
use super::watch::Watch;
use crate::control::{Reply, Server};
use crate::failure::{Context, Failure};
use crate::lock::Lock;
use crate::process_log::LogBounds;
use crate::programs::Programs;
use crate::rundir::RunDir;
use crate::supervision::Rules;
use crate::{leftovers, say};
use os::Os;

/// Time between two turns of the loop: a twentieth of the shortest silence that counts
/// (100 ms), at a fraction of a percent of a core.
const TURN: Duration = Duration::from_millis(5);

/// A cell that runs. Fields are dropped in this order: first the processes
/// end, then the services go, then the lock.
pub struct LiveCell {
    cell: SupervisorLoop<Os>,
    recording: RecordWatch,
    /// Ends when it is dropped.
    _logs: LogBounds,
    control: Server,
    processes: Vec<Process>,
    planning: Planning,
    started_ns: u64,
    end: Option<End>,
    _lock: Lock,
}

impl LiveCell {
    /// Takes the run directory, prepares the bus; processes start with
    /// [`LiveCell::stay`].
    pub fn start(plan: Plan) -> Result<Self, Failure> {
        let processes = Process::all(plan.spec.arms);
        let programs = Programs::of(&plan.spec);
        for process in &processes {
            // Before the run directory is made: a missing program must leave nothing behind.
            programs.path(*process)?;
        }
        install_stop_handler().cannot("listen to signals")?;
        private_umask();
        let lock = plan.dir.take(&plan.spec.cell)?;
        if let Some(line) = leftovers::wipe(&plan.dir)? {
            say::warn(line);
        }
        let (dir, root) = (plan.dir.clone(), plan.spec.root.clone());
        Self::prepare(plan, programs, processes, lock).inspect_err(|_| {
            // The failure is what the user has to know.
            leftovers::tidy(&dir, &root).ok();
        })
    }

    /// All that a run needs before its first process.
    fn prepare(
        mut plan: Plan,
        programs: Programs,
        processes: Vec<Process>,
        lock: Lock,
    ) -> Result<Self, Failure> {
        super::files::preflight::check(plan.dir.path())?;
        std::fs::create_dir_all(plan.dir.logs()).cannot("make the directory of the logs")?;
        std::fs::create_dir_all(plan.dir.black_boxes())
            .cannot("make the directory of the black boxes")?;
        plan.spec.built_in_dir =
            (plan.install)(&plan.dir.data()).cannot("write the built-in cells")?;
        plan.spec
            .save(&plan.dir.spec())
            .map_err(Failure::configuration)?;
        if let Some(secrets) = &plan.secrets {
            plan.dir.save_page(secrets)?;
        }
        let terms = terms(&plan, &processes);
        let dir = plan.dir.clone();
        let os = Os::new(plan, programs, processes.clone())?;
        Ok(Self {
            control: Server::open(&dir.control())?,
            cell: SupervisorLoop::new(os, terms),
            recording: RecordWatch::default(),
            _logs: LogBounds::start(dir.logs()),
            processes,
            planning: Planning::default(),
            started_ns: monotonic_ns(),
            end: None,
            _lock: lock,
        })
    }

    /// What the processes were told.
    pub fn spec(&self) -> &RunSpec {
        &self.plan().spec
    }

    /// Where it lives.
    pub fn run_dir(&self) -> &RunDir {
        &self.plan().dir
    }

    /// Which start of `process` is the newest.
    pub fn generation(&self, process: Process) -> u32 {
        self.cell.supervisor().generation(process)
    }

    /// What opens its page.
    pub fn secrets(&self) -> Option<&PageSecrets> {
        self.plan().secrets.as_ref()
    }

    /// The newest messages and signs of life of the processes.
    pub fn watch(&self) -> &Watch {
        self.cell.watch()
    }

    /// The processes with their pids.
    pub fn pids(&self) -> Vec<(Process, Option<u32>)> {
        let machine = self.cell.machine();
        let pid = |process: &Process| (*process, machine.pid(*process));
        self.processes.iter().map(pid).collect()
    }

    /// Stops the cell from outside, as Ctrl-C would.
    pub fn stop(&mut self) {
        self.finish_with(monotonic_ns(), End::Stopped(None));
    }

    /// Asks physics, as an operator would.
    pub fn ask(&mut self, action: OperatorAction) {
        self.cell.machine_mut().ask(action, 0);
    }

    /// Whether every process has shown itself.
    pub fn is_ready(&self) -> bool {
        self.cell.supervisor().is_ready()
    }

    /// Keeps the cell running to its end; `look` is called at every turn.
    pub fn stay(mut self, mut look: impl FnMut(&mut Self)) -> End {
        let mut swept = false;
        // Where it is refused, a busy machine delays restarts.
        set_fifo(LAUNCHER_PRIORITY).ok();
        while !self.cell.supervisor().is_down() {
            self.turn(monotonic_ns());
            if !swept && self.is_ready() {
                swept = true;
                let plan = self.plan();
                leftovers::sweep(&plan.dir, &plan.spec.prefix);
            }
            look(&mut self);
            std::thread::sleep(TURN);
        }
        set_other().ok();
        self.leave()
    }

    /// One look at everything.
    fn turn(&mut self, now: u64) {
        self.cell.look(now);
        self.take_verdict(now);
        self.recording.turn(now, &self.cell.machine().plan.dir);
        self.answer_clients(now);
        self.take_plan(now);
        match stop_count() {
            0 => {}
            1 => self.finish_with(now, End::Stopped(None)),
            // A second signal: the orderly stop takes too long for the person.
            _ => self.cell.abort(now),
        }
        self.cell.act(now);
        self.take_verdict(now);
    }

    /// Removes what the run leaves behind, once no process is left.
    fn leave(self) -> End {
        let Self {
            cell,
            mut recording,
            planning,
            mut end,
            mut control,
            _lock,
            ..
        } = self;
        let Os {
            children,
            bus,
            mut sweep,
            incidents,
            plan,
            ..
        } = cell.into_machine();
        drop(children);
        incidents.end();
        sweep.turn(monotonic_ns(), true, 0);
        planning.end();
        control.answer(&Reply::refused("the cell has ended"));
        drop((bus, control));
        let mut summary = match &mut end {
            Some(End::Finished(summary) | End::Stopped(Some(summary))) => Some(summary.as_mut()),
            _ => None,
        };
        recording.end(&plan.dir, &plan.spec.record, summary.as_deref_mut());
        if let Some(summary) = summary {
            summary.script_replies = script_report::load(plan.dir.path());
            report::of_replies(&summary.script_replies).for_each(say::warn);
            // The task wrote it before the decision that the run ends with.
            let message = Message::load(plan.dir.path());
            *summary = summary.clone().with_message(message.text());
        }
        if let Err(failure) = leftovers::tidy(&plan.dir, &plan.spec.root) {
            say::warn(failure);
        }
        end.unwrap_or(End::Stopped(None))
    }

    fn plan(&self) -> &Plan {
        &self.cell.machine().plan
    }

    /// Takes the end that the supervisor's loop found, with a summary of the run until then.
    fn take_verdict(&mut self, now: u64) {
        match self.cell.take_verdict() {
            Some(Verdict::GaveUp(failure)) => self.finish_with(now, End::GaveUp(failure)),
            Some(Verdict::Finished) => {
                let summary = self.summary(now).map(Box::new);
                let end = summary.map_or(End::Stopped(None), End::Finished);
                self.finish_with(now, end);
            }
            None => {}
        }
    }

    /// The first end counts; then everything stops in order.
    fn finish_with(&mut self, now: u64, mut end: End) {
        if self.end.is_none() {
            if let End::Stopped(summary) = &mut end {
                *summary = self.summary(now).map(Box::new);
            }
            self.end = Some(end);
            self.planning.close();
            self.cell.end(now);
        }
    }
}

/// What the supervision of `plan` depends on.
fn terms(plan: &Plan, processes: &[Process]) -> Terms {
    let task = plan.spec.task_program.as_deref();
    Terms {
        demo: plan.spec.demo.clone(),
        processes: processes.to_vec(),
        rules: Rules {
            watchdog: plan.watchdog,
            lockstep: plan.spec.speed.is_lockstep(),
            python_task: task.is_some_and(python::is_file),
        },
        script: plan.spec.script.clone(),
        gives_start: plan.spec.until_done || plan.loops,
        has_clients: plan.spec.fci.iter().any(Option::is_some),
    }
}
