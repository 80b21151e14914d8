//! A cell in one thread and virtual time: the real loops of its processes and of its supervisor,
//! on models of the bus, the disk and the processes.
//!
//! What a model takes over from the machine, and no more: the time of turns and wakes, starts,
//! signals, the slot files, the disk. Lost and late messages are not drawn: they follow.

mod damage;
mod disk;
mod faults;
mod launcher;
mod monitor;
mod running;

use std::cell::RefCell;
use std::rc::Rc;

use cell_bus::{Bus, Kept, MemorySite};
use cell_model::cells::script;
use cell_model::{Cell, Data};
use cell_rt::MemoryFile;
use cell_run::spec::RunSpec;
use controller_proc::Controllers;
use ipc_types::topic::Process;
use robocell_task::Policies;
use robocell_task_program::slots::ModelFiles;
use supervisor::supervision::Exit;

use crate::plan::{Fault, MS, Plan, noise};
use crate::scene::SceneDir;
use crate::stub;
use damage::Damage;
use disk::{Disk, STEPS};
pub use launcher::Launcher;
use running::Running;

/// A turn may be interrupted after fewer effects than this.
// Physics has some ten of them: its state, doorbells, copies for the recorder, its health.
const CUTS: u64 = 12;
/// Identity of the run in all messages.
const RUN: u64 = 1;

/// Something that happened, in the order of its happening.
#[derive(Clone, Debug)]
pub enum News {
    /// A line of the script disturbed the machine.
    Disturbed(Fault),
    /// A process was started by the launcher.
    Spawned(Process, u32),
    /// It starts on a file that was damaged, whose newest record is of this tick (0 where the file
    /// does not say so).
    Meets(Process, &'static str, u64),
    /// Its loop began.
    Began(Process, u32),
    /// It is gone; the launcher may not know it yet.
    Gone(Process, u32, Exit),
    /// The launcher sent it a signal.
    Signalled(Process, Signal),
    /// A line of the script stopped it, or lets it continue.
    Stopped(Process, bool),
    /// The launcher told the person.
    Warned(String),
    /// A process wrote to its log.
    Logged(Process, String),
}

/// A signal of the launcher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// SIGTERM.
    Terminate,
    /// SIGKILL.
    Kill,
}

/// Everything outside of the supervisor. Its clones are the same.
pub type Shared = Rc<RefCell<Model>>;

/// See [`Shared`].
pub struct Model {
    /// Topics, doorbells and the clock.
    pub site: MemorySite,
    /// What the processes are told.
    pub spec: RunSpec,
    /// The cell of the run.
    pub cell: Cell,
    plan: Plan,
    policies: Policies,
    _dir: Option<SceneDir>,
    controllers: Controllers,
    /// The processes that exist.
    #[expect(
        clippy::vec_box,
        reason = "one is taken out and put back for each turn"
    )]
    running: Vec<Box<Running>>,
    ended: Vec<(Process, u32, Exit)>,
    disk: Disk,
    requests: MemoryFile,
    task_files: ModelFiles,
    damages: Vec<Damage>,
    next_pid: u32,
    /// Draws of noise so far.
    draws: u64,
    /// Starts that fail, and starts that take so long (ms).
    failing: Vec<Process>,
    slow: Vec<(Process, u64)>,
    /// Steps of the present write after which its writer is killed.
    steps: Option<u64>,
    full_until_ns: u64,
    slow_disk_until_ns: u64,
    news: Vec<News>,
    /// The last lines of each process.
    logs: Vec<(Process, String)>,
}

impl Model {
    /// The cell of `plan`, in which no process runs yet.
    ///
    /// # Errors
    /// In words, where the scene of the plan does not exist.
    pub fn new(plan: &Plan) -> Result<Shared, String> {
        let (cell, dir) = if let Some(scene) = &plan.scene {
            let (cell, dir) = scene.load(plan.seed)?;
            (cell, Some(dir))
        } else {
            let cell = Cell::load(&Data::checkout(), &plan.demo, plan.seed, None);
            (cell.map_err(|error| error.to_string())?, None)
        };
        let arms = u8::try_from(cell.arms.len()).map_err(|error| error.to_string())?;
        let mut spec = plan.spec(arms).map_err(|error| error.to_string())?;
        let script = script::parse_for(&plan.script.join("\n"), "script", &cell);
        spec.script = script.map_err(|error| error.to_string())?;
        let site = MemorySite::new(arms).without_recorder();
        let file = || MemoryFile::new(site.effects());
        let model = Self {
            requests: file(),
            task_files: ModelFiles {
                newest: file(),
                history: file(),
            },
            damages: Vec::new(),
            site,
            spec,
            cell,
            plan: plan.clone(),
            policies: demos::policies().with(stub::kind()),
            _dir: dir,
            controllers: Controllers::default(),
            running: Vec::new(),
            ended: Vec::new(),
            disk: Disk::default(),
            next_pid: 1000,
            draws: 0,
            failing: Vec::new(),
            slow: Vec::new(),
            steps: None,
            full_until_ns: 0,
            slow_disk_until_ns: 0,
            news: Vec::new(),
            logs: Vec::new(),
        };
        Ok(Rc::new(RefCell::new(model)))
    }

    /// The processes of the cell.
    pub fn processes(&self) -> Vec<Process> {
        Process::all(self.spec.arms)
    }

    /// What happened since the last call.
    pub fn take_news(&mut self) -> Vec<News> {
        std::mem::take(&mut self.news)
    }

    /// A number below `below`.
    fn draw(&mut self, below: u64) -> u64 {
        self.draws += 1;
        noise(self.plan.seed, 1, self.draws) % below.max(1)
    }

    fn now_ns(&self) -> u64 {
        cell_rt::Clock::now_ns(&self.site)
    }

    pub(crate) fn bus(&self, generation: u32) -> Bus {
        Bus::in_memory(&self.site, RUN, generation)
    }

    /// The bus of a reader that does not disturb a process.
    pub(crate) fn readers_bus(&self) -> Bus {
        self.bus(1)
    }

    /// A bus on which every message comes as it was sent.
    pub(crate) fn faithful_bus(&self) -> Bus {
        Bus::in_memory(&self.site.faithful(), RUN, 1)
    }

    fn index(&self, process: Process) -> Option<usize> {
        self.running.iter().position(|one| one.process == process)
    }

    /// The next process whose turn it is, and when; at equal times the first of the cell.
    pub fn next(&self) -> Option<(u64, Process)> {
        let due = self.running.iter().map(|one| (one.due_ns(), one.process));
        due.min_by_key(|(due_ns, _)| *due_ns)
    }

    /// Fulfils faults whose time is over.
    fn look_at_disk(&mut self) {
        let now_ns = self.now_ns();
        self.disk.set_full(now_ns < self.full_until_ns);
        if now_ns >= self.slow_disk_until_ns {
            self.disk.set_write_ms(2);
        }
    }

    /// One turn of `process` at `now_ns`; whether anything of it can be noticed.
    pub fn turn(&mut self, now_ns: u64, process: Process) -> bool {
        self.site.set_now_ns(now_ns);
        self.look_at_disk();
        let Some(index) = self.index(process) else {
            return false;
        };
        let mut one = self.running.remove(index);
        let (exit, has_worked) = self.turn_of(&mut one, now_ns);
        for line in cell_worker::keep_lines() {
            self.logs.push((process, line.clone()));
            self.news.push(News::Logged(process, line));
        }
        match exit {
            None => self.running.insert(index, one),
            Some(exit) => self.gone(one, exit),
        }
        if has_worked {
            self.notice(now_ns);
        }
        has_worked
    }

    /// Why it ended, if it did, and whether others may notice something of it.
    fn turn_of(&mut self, one: &mut Running, now_ns: u64) -> (Option<Exit>, bool) {
        one.waited(now_ns);
        let kept = one.take_kept();
        if !kept.is_empty() {
            kept.into_iter().for_each(Kept::happen);
            return (None, true);
        }
        if one.is_stopping {
            return (Some(Exit::Code(0)), true);
        }
        if one.turns.is_none() {
            return (self.begin(one, now_ns).err(), true);
        }
        let jitter_ns = self.jitter_ns();
        let cost_ns = one.cost_ns(self.draw(100));
        let allowed = one.cut.unwrap_or(u64::MAX);
        let effects = self.site.effects().clone();
        effects.allow(allowed);
        let worked = || effects.left() < allowed;
        let (gap_ns, until_ns) = one.preempted;
        if now_ns < until_ns {
            let effects = self.draw(CUTS);
            self.site.cut_after(effects, gap_ns);
        }
        let has_worked = one.turn(now_ns, jitter_ns, cost_ns, worked);
        effects.allow(u64::MAX);
        one.keep(self.site.end_cut(), now_ns + gap_ns);
        self.site.set_now_ns(now_ns);
        let is_physics = one.process == Process::Physics;
        self.steps = is_physics.then(|| self.disk.take_cut()).flatten();
        let is_cut = one.cut.is_some() || self.steps.is_some();
        (is_cut.then_some(Exit::Signal(9)), has_worked || is_cut)
    }

    /// The process has done what its start needs.
    fn begin(&mut self, one: &mut Running, now_ns: u64) -> Result<(), Exit> {
        let failing = self.failing.iter().position(|other| *other == one.process);
        if let Some(failing) = failing {
            self.failing.remove(failing);
            self.logs.push((one.process, "injected failure".to_owned()));
            return Err(Exit::Code(1));
        }
        self.meet_damage(one.process);
        let turns = self.set_up(one.process, one.generation);
        let (turns, sleeper) = turns.map_err(|error| {
            self.logs.push((one.process, error));
            Exit::Code(1)
        })?;
        one.begin(turns, sleeper, now_ns);
        self.news.push(News::Began(one.process, one.generation));
        Ok(())
    }

    /// It is not there any more: no destructor of it has an effect.
    fn gone(&mut self, one: Box<Running>, exit: Exit) {
        self.site.effects().allow(0);
        let (process, generation) = (one.process, one.generation);
        drop(one);
        self.site.effects().allow(u64::MAX);
        if process == Process::Physics {
            let now_ns = self.now_ns();
            let is_writing = self.disk.is_writing(now_ns);
            let drawn = is_writing.then(|| self.draw(STEPS + 1));
            let steps = self.steps.take().or(drawn);
            self.disk.kill(now_ns, steps.unwrap_or(STEPS));
        }
        self.ended.push((process, generation, exit));
        self.news.push(News::Gone(process, generation, exit));
    }

    /// Wakes those who wait for an effect of another.
    fn notice(&mut self, now_ns: u64) {
        let mut running = std::mem::take(&mut self.running);
        for one in &mut running {
            one.notice(now_ns, || 10_000 + self.jitter_ns() / 2);
        }
        self.running = running;
    }

    /// How late a process is woken (ns).
    fn jitter_ns(&mut self) -> u64 {
        let (most, rare) = if self.plan.fifo {
            (20_000, 0)
        } else {
            (60_000, 2 * MS)
        };
        let is_rare = rare > 0 && self.draw(200) == 0;
        self.draw(if is_rare { rare } else { most })
    }
}
