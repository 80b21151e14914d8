//! The processes of a running cell: children of the launcher, on a bus in shared memory.

use cell_bus::RunSite;
use cell_model::cells::script::ScriptAction;
use cell_rt::process::{SIGCONT, SIGSTOP, Share};
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;

use crate::child::{Children, last_words};
use crate::failure::{Context, Failure};
use crate::programs::Programs;
use crate::run::bus_thread::BusThread;
use crate::run::faults::disturbances::Disturbances;
use crate::run::faults::half_made::HalfMadeSweep;
use crate::run::files::incident::IncidentRecorder;
use crate::run::files::room::Room;
use crate::run::machine::{Machine, Threads};
use crate::run::plan::Plan;
use crate::run::watch::{News, Watch};
use crate::run::wish::choose_policy;
use crate::supervision::Exit;
use crate::{leftovers, say};

/// Fields are dropped in this order: first the processes end, then the services go.
pub(super) struct Os {
    pub(super) children: Children,
    pub(super) bus: BusThread,
    pub(super) sweep: HalfMadeSweep,
    pub(super) incidents: IncidentRecorder,
    disturbances: Disturbances,
    room: Room,
    processes: Vec<Process>,
    pub(super) plan: Plan,
}

impl Os {
    /// Prepares the bus for the processes of `plan`; none of them runs yet.
    pub(super) fn new(
        plan: Plan,
        programs: Programs,
        processes: Vec<Process>,
    ) -> Result<Self, Failure> {
        let site = RunSite {
            root: plan.spec.root.clone(),
            prefix: plan.spec.prefix.clone(),
        };
        Ok(Self {
            bus: BusThread::start(site.clone(), plan.spec.run, &processes)?,
            children: Children::new(plan.dir.clone(), programs).cannot("open the run directory")?,
            sweep: HalfMadeSweep::new(site),
            incidents: IncidentRecorder::new(&plan.spec, &plan.dir, &processes),
            disturbances: Disturbances::default(),
            room: Room::new(plan.dir.path(), plan.spec.arms),
            processes,
            plan,
        })
    }
}

impl Machine for Os {
    fn spawn(&mut self, process: Process, generation: u32) -> Result<(), String> {
        self.children.spawn(process, generation)
    }

    fn terminate(&mut self, process: Process) {
        self.children.terminate(process);
    }

    fn kill(&mut self, process: Process) {
        self.children.kill(process);
    }

    fn freeze(&mut self, process: Process) {
        self.children.signal(process, SIGSTOP);
    }

    fn thaw(&mut self, process: Process) {
        self.children.signal(process, SIGCONT);
    }

    fn choose(&mut self, policy: &str) -> Result<(), String> {
        choose_policy(&mut self.plan, policy).map_err(|failure| failure.message)
    }

    fn disturb(&mut self, now_ns: u64, action: &ScriptAction) -> Result<(), String> {
        self.disturbances
            .begin(self.plan.dir.path(), now_ns, action)
    }

    fn end_disturbances(&mut self, now_ns: u64) {
        self.disturbances.turn(now_ns);
    }

    fn reap(&mut self) -> Vec<(Process, u32, Exit)> {
        self.children.reap()
    }

    fn pid(&self, process: Process) -> Option<u32> {
        self.children.pid(process)
    }

    fn threads(&self, pid: u32, all: bool) -> Option<Threads> {
        let others = if all { Share::of_others(pid) } else { vec![] };
        Some((Share::of(pid)?, others))
    }

    fn lack_of_room(&self) -> Option<String> {
        self.room.lack()
    }

    fn remove_half_made(&mut self, now_ns: u64, ended: bool, silence_ns: u64) {
        self.sweep.turn(now_ns, ended, silence_ns);
    }

    fn news(&mut self, now_ns: u64) -> News {
        self.bus.take(now_ns)
    }

    fn deaf_ns(&self, now_ns: u64) -> u64 {
        self.bus.deaf_ns(now_ns)
    }

    fn ask(&mut self, action: OperatorAction, count: u32) {
        self.bus.ask(action, count);
    }

    fn new_bus(&mut self) -> Result<(), Failure> {
        let spec = &mut self.plan.spec;
        let old_root = spec.root.clone();
        // Other names, so that no process opens the old files; the run keeps its number.
        (spec.root, spec.prefix) = self.plan.dir.site(spec.run.wrapping_add(1));
        spec.save(&self.plan.dir.spec())
            .map_err(Failure::configuration)?;
        let site = RunSite {
            root: spec.root.clone(),
            prefix: spec.prefix.clone(),
        };
        let bus = BusThread::start(site.clone(), spec.run, &self.processes)?;
        drop(std::mem::replace(&mut self.bus, bus));
        self.sweep = HalfMadeSweep::new(site);
        leftovers::sweep(&self.plan.dir, &self.plan.spec.prefix);
        leftovers::remove(&old_root).cannot(format!("remove {}", old_root.display()))
    }

    fn note(&mut self, now_ns: u64, watch: &Watch) {
        self.incidents.turn(now_ns, watch);
    }

    fn incident(&mut self, now_ns: u64, process: Process, what: &str) -> String {
        let number = self.incidents.failed(now_ns, process, what);
        self.incidents.hint(number)
    }

    fn last_words(&self, process: Process, count: usize) -> Vec<String> {
        last_words(&self.plan.dir.log(&process.name()), count)
    }

    fn warn(&mut self, text: &str) {
        say::warn(text);
    }
}
