//! Turns of the loop on a model of the processes.

use std::collections::HashMap;

use cell_rt::process::Share;
use ipc_types::topic::Process::{self, Controller, Monitor, Physics, Task};
use ipc_types::{Health, Wire, WorldState};

use super::*;
use crate::run::machine::Threads;
use crate::run::watch::News;
use crate::supervision::{Exit, MS};
use cell_model::cells::script::ScriptAction;

const ALL: [Process; 4] = [Physics, Controller(0), Task, Monitor];
const REASON: &str = "/dev/shm has 1 KiB free";

/// Processes that work until they are stopped or killed.
#[derive(Default)]
struct Model {
    alive: HashMap<Process, u32>,
    frozen: Vec<Process>,
    ended: Vec<(Process, u32, Exit)>,
    cycles: u64,
    script_line: u32,
    full: bool,
    deaf: bool,
    now_ns: u64,
    heard_ns: u64,
    buses: u32,
    requests: Vec<(OperatorAction, u32)>,
    incidents: Vec<String>,
    warnings: Vec<String>,
}

impl Machine for Model {
    fn spawn(&mut self, process: Process, generation: u32) -> Result<(), String> {
        let before = self.alive.insert(process, generation);
        assert_eq!(before, None, "one of {process:?} runs");
        Ok(())
    }

    fn terminate(&mut self, process: Process) {
        let generation = self.alive.remove(&process).unwrap();
        self.ended.push((process, generation, Exit::Code(0)));
    }

    fn kill(&mut self, process: Process) {
        let generation = self.alive.remove(&process).unwrap();
        self.ended.push((process, generation, Exit::Signal(9)));
    }

    fn freeze(&mut self, process: Process) {
        self.frozen.push(process);
    }

    fn thaw(&mut self, process: Process) {
        self.frozen.retain(|frozen| *frozen != process);
    }

    fn choose(&mut self, _: &str) -> Result<(), String> {
        Ok(())
    }

    fn disturb(&mut self, _: u64, _: &ScriptAction) -> Result<(), String> {
        Ok(())
    }

    fn end_disturbances(&mut self, _: u64) {}

    fn reap(&mut self) -> Vec<(Process, u32, Exit)> {
        std::mem::take(&mut self.ended)
    }

    fn pid(&self, process: Process) -> Option<u32> {
        self.alive.get(&process).copied()
    }

    fn threads(&self, _: u32, _: bool) -> Option<Threads> {
        Some((Share::default(), vec![]))
    }

    fn lack_of_room(&self) -> Option<String> {
        self.full.then(|| REASON.to_owned())
    }

    fn remove_half_made(&mut self, _: u64, _: bool, _: u64) {}

    fn news(&mut self, now_ns: u64) -> News {
        self.now_ns = now_ns;
        if self.deaf {
            return News::default();
        }
        let listened_ns = now_ns - std::mem::replace(&mut self.heard_ns, now_ns);
        self.cycles += 5;
        let works = |process: &&Process| !self.frozen.contains(process);
        let health = |process: &Process| {
            let mut health = Health::zeroed();
            health.header.generation = *self.alive.get(process)?;
            health.cycles = self.cycles;
            Some((*process, Box::new(health)))
        };
        let mut state = WorldState::zeroed();
        state.script_line = self.script_line;
        News {
            state: Some(Box::new(state)),
            healths: ALL.iter().filter(works).filter_map(health).collect(),
            listened_ns,
            ..News::default()
        }
    }

    fn deaf_ns(&self, now_ns: u64) -> u64 {
        now_ns - self.heard_ns
    }

    fn ask(&mut self, action: OperatorAction, count: u32) {
        self.requests.push((action, count));
        self.script_line = 0;
    }

    fn new_bus(&mut self) -> Result<(), Failure> {
        assert!(self.alive.is_empty());
        self.buses += 1;
        self.heard_ns = self.now_ns;
        Ok(())
    }

    fn note(&mut self, _: u64, _: &Watch) {}

    fn incident(&mut self, _: u64, _: Process, what: &str) -> String {
        self.incidents.push(what.to_owned());
        "`robocell incident 1` shows it".to_owned()
    }

    fn last_words(&self, _: Process, _: usize) -> Vec<String> {
        vec!["warning: out of cubes".to_owned()]
    }

    fn warn(&mut self, text: &str) {
        self.warnings.push(text.to_owned());
    }
}

/// A cell of which every process works, at the given time.
struct Cell(SupervisorLoop<Model>, u64);

impl Cell {
    fn up(script: &str) -> Self {
        let terms = Terms {
            demo: "reach".to_owned(),
            processes: ALL.to_vec(),
            rules: Rules {
                watchdog: true,
                lockstep: false,
                python_task: false,
            },
            script: cell_model::cells::script::parse(script, "s").unwrap(),
            gives_start: false,
            has_clients: false,
        };
        let mut cell = Self(SupervisorLoop::new(Model::default(), terms), 0);
        cell.run(100);
        assert!(cell.0.supervisor().is_ready());
        cell
    }

    fn run(&mut self, ms: u64) {
        for _ in 0..ms / 5 {
            self.1 += 5 * MS;
            self.0.look(self.1);
            self.0.act(self.1);
        }
    }

    fn model(&mut self) -> &mut Model {
        self.0.machine_mut()
    }
}

#[test]
fn physics_is_told_of_a_script_line_once_the_next_start_runs_or_the_stop_began() {
    let mut cell = Cell::up(
        "{\"at_s\": 1, \"do\": \"kill\", \"process\": \"task\"}\n\
         {\"at_s\": 2, \"do\": \"stop\", \"process\": \"controller\", \"for_s\": 0.05}",
    );
    cell.model().script_line = 1;
    cell.run(5);
    assert_eq!(cell.model().requests, []);
    cell.run(20);
    assert_eq!(cell.model().requests, [(OperatorAction::ScriptDone, 1)]);
    assert_eq!(cell.model().alive[&Task], 2);
    assert_eq!(cell.model().incidents, ["task was killed by the script"]);
    assert_eq!(cell.model().warnings, [""; 0], "it was asked for");
    cell.model().script_line = 2;
    cell.run(10);
    assert_eq!(cell.model().frozen, [Controller(0)]);
    cell.run(50);
    assert!(cell.model().frozen.is_empty());
    assert_eq!(
        cell.model().alive[&Controller(0)],
        1,
        "within its time limit"
    );
}

#[test]
fn a_process_that_ends_without_room_is_started_again_when_there_is_room() {
    let mut cell = Cell::up("");
    cell.model().full = true;
    cell.run(10);
    let generation = cell.model().alive.remove(&Task).unwrap();
    cell.model().ended.push((Task, generation, Exit::Code(101)));
    cell.run(1000);
    assert!(!cell.model().alive.contains_key(&Task));
    assert!(cell.model().warnings[0].contains(REASON));
    cell.model().full = false;
    cell.run(50);
    assert_eq!(cell.model().alive[&Task], 2);
    assert!(cell.model().warnings.last().unwrap().contains("room again"));
}

#[test]
fn what_a_process_wrote_last_is_part_of_the_report_of_its_end() {
    let mut cell = Cell::up("");
    let generation = cell.model().alive.remove(&Task).unwrap();
    cell.model().ended.push((Task, generation, Exit::Code(1)));
    cell.run(50);
    let said = &cell.model().warnings[0];
    assert!(
        said.contains("exit code 1") && said.contains(": out of cubes; "),
        "{said}"
    );
}

#[test]
fn a_bus_on_which_nothing_is_received_is_replaced_once_and_then_the_run_is_given_up() {
    let mut cell = Cell::up("");
    cell.model().deaf = true;
    cell.run(31_000);
    assert_eq!(cell.model().buses, 1);
    assert!(cell.0.take_verdict().is_none());
    cell.run(31_000);
    let verdict = cell.0.take_verdict();
    let Some(Verdict::GaveUp(failure)) = verdict else {
        panic!("{verdict:?}");
    };
    assert!(failure.message.contains("for 30 s"), "{}", failure.message);
    cell.run(1000);
    assert!(cell.0.supervisor().is_down());
}
