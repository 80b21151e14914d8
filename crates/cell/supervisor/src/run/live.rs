//! A running cell: the launcher's loop around the supervisor.

mod actions;
mod bus;
mod ending;
mod requests;
mod result;

use std::time::Duration;

use cell_bus::RunSite;
use cell_model::runs::message::Message;
use cell_model::runs::python;
use cell_model::runs::report;
use cell_model::runs::script_report;
use cell_model::runs::spec::{PageSecrets, RunSpec};
use cell_model::runs::summary::RunSummary;
use cell_rt::clock::monotonic_ns;
use cell_rt::priority::{LAUNCHER_PRIORITY, set_fifo, set_other};
use cell_rt::process::private_umask;
use cell_rt::signal::{install_stop_handler, stop_count};
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;

use super::bus_thread::BusThread;
use super::faults::Faults;
use super::half_made::HalfMadeSweep;
use super::incident::IncidentRecorder;
use super::plan::Plan;
use super::planning::Planning;
use super::recording::RecordWatch;
use super::room::Room;
use super::standstill::Standstill;
use super::starvation::{Running, Starvation};
use super::watch::Watch;
use crate::child::Children;
use crate::control::{Reply, Server};
use crate::failure::{Context, Failure};
use crate::lock::Lock;
use crate::process_log::LogBounds;
use crate::programs::Programs;
use crate::rundir::RunDir;
use crate::supervision::{Event, Rules, Supervisor};
use crate::{leftovers, say};

/// How often the launcher looks.
const TURN: Duration = Duration::from_millis(5);

/// How a run ended.
pub enum End {
    /// With the task, or at its time limit.
    Finished(Box<RunSummary>),
    /// On request, with what was reached by then; nothing where physics never ran.
    Stopped(Option<Box<RunSummary>>),
    /// Because another scene was asked for.
    Replaced(Box<Plan>),
    /// Because a process could not be kept running, or refused the cell.
    GaveUp(Failure),
}

/// A cell that runs. Fields are dropped in this order: first the processes
/// end, then the services go, then the lock.
pub struct LiveCell {
    children: Children,
    bus: BusThread,
    watch: Watch,
    sweep: HalfMadeSweep,
    starvation: Starvation,
    recording: RecordWatch,
    incidents: IncidentRecorder,
    room: Room,
    has_room: bool,
    /// Ends when it is dropped.
    _logs: LogBounds,
    control: Server,
    supervisor: Supervisor,
    faults: Faults,
    processes: Vec<Process>,
    plan: Plan,
    planning: Planning,
    started_ns: u64,
    start_event_given: bool,
    standstill: Standstill,
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
        super::preflight::check(plan.dir.path())?;
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
        let site = RunSite {
            root: plan.spec.root.clone(),
            prefix: plan.spec.prefix.clone(),
        };
        let bus = BusThread::start(site.clone(), plan.spec.run, &processes)?;
        let control = Server::open(&plan.dir.control())?;
        let mut order = processes.clone();
        // The monitor keeps the log, so it is there before the task's first line.
        order.sort_by_key(|process| *process == Process::Task);
        let rules = Rules {
            watchdog: plan.watchdog,
            lockstep: plan.spec.speed.is_lockstep(),
            python_task: plan
                .spec
                .task_program
                .as_deref()
                .is_some_and(python::is_file),
        };
        Ok(Self {
            children: Children::new(plan.dir.clone(), programs),
            bus,
            watch: Watch::new(&processes),
            sweep: HalfMadeSweep::new(site),
            starvation: Starvation::default(),
            recording: RecordWatch::default(),
            incidents: IncidentRecorder::new(&plan.spec, &plan.dir, &processes),
            room: Room::new(plan.dir.path(), plan.spec.arms),
            has_room: true,
            _logs: LogBounds::start(plan.dir.logs()),
            control,
            supervisor: Supervisor::new(&order, rules),
            faults: Faults::new(&plan.spec.script, &processes),
            processes,
            plan,
            planning: Planning::default(),
            started_ns: monotonic_ns(),
            start_event_given: false,
            standstill: Standstill::default(),
            end: None,
            _lock: lock,
        })
    }

    /// What the processes were told.
    pub fn spec(&self) -> &RunSpec {
        &self.plan.spec
    }

    /// Where it lives.
    pub fn run_dir(&self) -> &RunDir {
        &self.plan.dir
    }

    /// Which start of `process` is the newest.
    pub fn generation(&self, process: Process) -> u32 {
        self.supervisor.generation(process)
    }

    /// What opens its page.
    pub fn secrets(&self) -> Option<&PageSecrets> {
        self.plan.secrets.as_ref()
    }

    /// The newest messages and signs of life of the processes.
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// The processes with their pids.
    pub fn pids(&self) -> Vec<(Process, Option<u32>)> {
        self.processes
            .iter()
            .map(|p| (*p, self.children.pid(*p)))
            .collect()
    }

    /// Stops the cell from outside, as Ctrl-C would.
    pub fn stop(&mut self) {
        self.finish_with(End::Stopped(None));
    }

    /// Asks physics, as an operator would.
    pub fn ask(&mut self, action: OperatorAction) {
        self.bus.ask(action, 0);
    }

    /// Whether every process has shown itself.
    pub fn is_ready(&self) -> bool {
        self.supervisor.is_ready()
    }

    /// Keeps the cell running to its end; `look` is called at every turn.
    pub fn stay(mut self, mut look: impl FnMut(&mut Self)) -> End {
        let mut swept = false;
        // Where it is refused, a busy machine delays restarts.
        set_fifo(LAUNCHER_PRIORITY).ok();
        while !self.supervisor.is_down() {
            self.turn();
            if !swept && self.is_ready() {
                swept = true;
                leftovers::sweep(&self.plan.dir, &self.plan.spec.prefix);
            }
            look(&mut self);
            std::thread::sleep(TURN);
        }
        set_other().ok();
        let Self {
            children,
            bus,
            mut sweep,
            mut recording,
            incidents,
            plan,
            planning,
            mut end,
            mut control,
            _lock,
            ..
        } = self;
        drop(children);
        incidents.end();
        sweep.turn(monotonic_ns(), true, 0);
        planning.end();
        control.answer(&Reply::refused("the cell has ended"));
        drop((bus, control));
        if let Some(End::Finished(summary) | End::Stopped(Some(summary))) = &mut end {
            recording.end(&plan.dir, &plan.spec.record, summary);
            summary.script_replies = script_report::load(plan.dir.path());
            report::of_replies(&summary.script_replies).for_each(say::warn);
            // The task wrote it before the decision that the run ends with.
            let message = Message::load(plan.dir.path());
            **summary = summary.as_ref().clone().with_message(message.text());
        }
        if let Err(failure) = leftovers::tidy(&plan.dir, &plan.spec.root) {
            say::warn(failure);
        }
        end.unwrap_or(End::Stopped(None))
    }

    /// One look at everything.
    pub fn turn(&mut self) {
        let now = monotonic_ns();
        let ended = self.children.reap();
        let silence_ns = self.supervisor.longest_silence();
        self.sweep.turn(now, !ended.is_empty(), silence_ns);
        self.look_for_room(now);
        for (process, generation, exit) in ended {
            self.tell(
                now,
                Event::Exited {
                    process,
                    generation,
                    exit,
                },
            );
        }
        self.listen(now);
        for event in self.starvation.poll(now, &self.running()) {
            self.tell(now, event);
        }
        self.recording.turn(now, &self.plan.dir);
        self.incidents.turn(now, &self.watch);
        self.look_for_the_end();
        self.act_on_script(now);
        self.answer_clients(now);
        self.take_plan();
        match stop_count() {
            0 => {}
            1 => self.finish_with(End::Stopped(None)),
            _ => self.tell(now, Event::Abort),
        }
        let mut actions = Vec::new();
        self.supervisor.poll(now, &mut actions);
        self.obey(now, actions);
    }

    /// Without room a process could not start; the others hold what they hold.
    fn look_for_room(&mut self, now: u64) {
        let lack = self.room.lack();
        if lack.is_none() == self.has_room {
            return;
        }
        self.has_room = lack.is_none();
        match lack {
            Some(lack) => say::warn(format_args!(
                "{lack}: a process that ends is started again when there is room"
            )),
            None => say::warn("there is room again for a process to start"),
        }
        self.tell(now, Event::Room(self.has_room));
    }

    /// The processes that exist.
    fn running(&self) -> Vec<Running> {
        let of = |process: &Process| {
            Some(Running {
                process: *process,
                generation: self.supervisor.generation(*process),
                pid: self.children.pid(*process)?,
                silence_ns: self.supervisor.silence(*process),
            })
        };
        self.processes.iter().filter_map(of).collect()
    }
}
