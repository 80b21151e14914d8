//! A physics that is killed and started again, in one process.

use std::cell::RefCell;
use std::io;
use std::path::PathBuf;
use std::rc::Rc;

use cell_model::{Cell, Data};
use cell_rt::{MemoryFile, SlotFile};
use cell_run::spec::{RecordSpec, RunSpec};
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{Decision, OperatorRequest, Wire, WorldState};

use super::requests::{RECORD_BYTES, REQUESTS, Requests};
use super::writer::Writer;
use super::{Resume, Store};
use crate::plant::{Next, Plant};
use crate::world::StepInput;

const RUN: u64 = 7;

struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let dir = format!("robocell-resume-{name}-{}", std::process::id());
        let dir = std::env::temp_dir().join(dir);
        std::fs::create_dir_all(&dir).unwrap();
        Self(dir)
    }

    /// A process of physics, the first or a later one.
    fn start(&self, was_one: bool) -> Physics {
        let mut plant = plant();
        let resume = Resume::open(&self.0, RUN, was_one, &mut plant);
        Physics::with(plant, resume)
    }
}

fn plant() -> Plant {
    let cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
    Plant::new(&cell, &spec()).unwrap()
}

/// States in memory; a write is finished when its result is asked for.
#[derive(Clone, Default)]
struct MemoryStore {
    /// Newest first.
    states: Rc<RefCell<Vec<Vec<u8>>>>,
    written: Option<u64>,
}

impl Store for MemoryStore {
    fn read(&self) -> io::Result<Option<Vec<u8>>> {
        Ok(self.states.borrow().first().cloned())
    }

    fn read_older(&self) -> io::Result<Option<Vec<u8>>> {
        Ok(self.states.borrow().get(1).cloned())
    }

    fn replace_by_older(&self) -> io::Result<()> {
        self.states.borrow_mut().remove(0);
        Ok(())
    }

    fn name(&self) -> String {
        "memory".to_owned()
    }

    fn is_idle(&self) -> bool {
        self.written.is_none()
    }

    fn write(&mut self, tick: u64, fill: impl FnOnce(&mut Vec<u8>)) {
        let mut state = Vec::new();
        fill(&mut state);
        self.states.borrow_mut().insert(0, state);
        self.written = Some(tick);
    }

    fn result(&mut self) -> Option<(u64, Result<(), String>)> {
        self.written.take().map(|tick| (tick, Ok(())))
    }

    fn wait(&mut self) {}
}

fn spec() -> RunSpec {
    serde_json::from_value(serde_json::json!({
        "run": RUN, "cell": "test", "demo": "franka-stack", "policy": "fsm", "seed": 1,
        "speed": "max", "data_dir": null, "run_dir": "", "root": "", "prefix": "",
        "arms": 1, "robot": null, "script": [], "paused": false, "until_done": false,
        "time_limit_s": null, "real_time": false, "page": null,
        "record": RecordSpec::default(),
    }))
    .unwrap()
}

impl Drop for Place {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

struct Physics<S = Writer> {
    plant: Plant,
    resume: Resume<S>,
    /// Breakpoint that the task reached.
    break_tick: u64,
    lost: Vec<String>,
}

impl<S: Store> Physics<S> {
    fn with(plant: Plant, resume: Resume<S>) -> Self {
        Self {
            plant,
            resume,
            break_tick: 0,
            lost: Vec::new(),
        }
    }

    fn tick(&self) -> u64 {
        self.plant.world().tick()
    }

    /// One tick of the process in lockstep.
    fn turn(&mut self) -> Next {
        let mut decision = Decision::zeroed();
        decision.break_tick = self.break_tick;
        let next = self.plant.before_step(Some(&decision));
        if next == Next::Step {
            self.plant.step(&StepInput::default());
        }
        self.resume.announce(&self.plant);
        self.resume.save(&self.plant);
        self.resume.wait(self.tick());
        self.lost.push(self.resume.lost(self.tick()));
        next
    }

    fn run_to(&mut self, tick: u64) {
        while self.tick() < tick && self.turn() == Next::Step {}
    }

    fn ask(&mut self, action: OperatorAction, count: u32) {
        let mut request = OperatorRequest::zeroed_at_identity();
        request.action = action.code();
        request.count = count;
        let reply = self.plant.answer_request(&request);
        assert_eq!(
            reply.code,
            ReplyCode::Accepted.code(),
            "{:?}",
            reply.message.as_str()
        );
        self.resume.note(&self.plant, &request, &reply);
    }

    fn state(&self) -> WorldState {
        let mut state = WorldState::zeroed();
        self.plant.write_state(&mut state);
        state
    }
}

#[test]
fn a_kill_at_any_tick_costs_less_than_a_second() {
    let place = Place::new("any");
    for killed_at in [1, 499, 500, 501, 990, 1_490, 2_003, 3_170] {
        let mut first = place.start(false);
        first.run_to(killed_at);
        drop(first);
        let second = place.start(true);
        assert!(killed_at - second.tick() <= 1_000, "{killed_at}");
        assert_eq!(second.resume.lost(second.tick()), "");
    }
}

#[test]
fn states_and_requests_in_memory_are_resumed_like_those_in_files() {
    let (store, requests) = (MemoryStore::default(), MemoryFile::default());
    let start = |was_one| {
        let mut plant = plant();
        let file = SlotFile::in_memory(&requests, RECORD_BYTES, REQUESTS);
        let file = file.map(|file| Requests::of(file, RUN));
        let resume = Resume::with(store.clone(), file, RUN, was_one, &mut plant);
        Physics::with(plant, resume)
    };
    let mut first = start(false);
    first.run_to(1_015);
    first.ask(OperatorAction::TaskStart, 0);
    first.ask(OperatorAction::TaskPause, 0);
    let before = first.state().panel;
    drop(first);
    let second = start(true);
    assert_eq!(second.tick(), 1_010, "as from files");
    assert_eq!(second.resume.lost(second.tick()), "");
    assert_eq!(second.state().panel, before);
}

#[test]
fn requests_after_the_newest_saved_state_are_obeyed_again_and_once() {
    let place = Place::new("requests");
    let mut first = place.start(false);
    first.run_to(1_015);
    first.ask(OperatorAction::TaskStart, 0);
    first.ask(OperatorAction::TaskPause, 0);
    first.run_to(1_030);
    let before = first.state().panel;
    drop(first);
    let mut second = place.start(true);
    assert_eq!(second.tick(), 1_010, "the state is older than the requests");
    assert_eq!(second.state().panel, before);
    second.run_to(1_200);
    drop(second);
    let third = place.start(true);
    assert!(third.tick() > 1_030);
    assert_eq!(third.state().panel, before);
}

#[test]
fn requests_that_do_not_fit_are_reported_as_lost() {
    let place = Place::new("many");
    let mut first = place.start(false);
    first.run_to(1_015);
    for _ in 0..70 {
        first.ask(OperatorAction::TaskStart, 0);
    }
    drop(first);
    let second = place.start(true);
    let lost = second.resume.lost(second.tick());
    assert!(lost.contains("6 requests"), "{lost}");
}

#[test]
fn every_damaged_word_of_the_newest_request_is_reported() {
    // The head of the file and of the record, and the record.
    let words = 2 + 3 + RECORD_BYTES.div_ceil(8) as u64;
    for word in (0..words).step_by(3) {
        let (store, requests) = (MemoryStore::default(), MemoryFile::default());
        let start = |was_one| {
            let mut plant = plant();
            let file = SlotFile::in_memory(&requests, RECORD_BYTES, REQUESTS);
            let file = file.map(|file| Requests::of(file, RUN));
            let resume = Resume::with(store.clone(), file, RUN, was_one, &mut plant);
            Physics::with(plant, resume)
        };
        let mut first = start(false);
        first.run_to(15);
        first.ask(OperatorAction::TaskPause, 0);
        drop(first);
        requests.flip(word).unwrap();
        let second = start(true);
        let lost = second.resume.lost(second.tick());
        assert!(lost.contains("requests of people"), "word {word}: {lost}");
    }
}

#[test]
fn a_breakpoint_that_was_reached_does_not_pause_again_after_a_restart() {
    let place = Place::new("break");
    let mut first = place.start(false);
    first.run_to(700);
    first.break_tick = 700;
    assert_eq!(first.turn(), Next::Wait);
    first.ask(OperatorAction::Resume, 0);
    first.run_to(1_300);
    drop(first);
    let mut second = place.start(true);
    second.break_tick = 700;
    second.run_to(1_400);
    assert_eq!(second.tick(), 1_400);
}

#[test]
fn a_state_that_cannot_be_saved_is_reported_until_one_is() {
    let place = Place::new("full");
    let mut physics = place.start(false);
    physics.run_to(1_200);
    // A directory in the place of the file that is written first.
    let next = place.0.join("physics.next");
    std::fs::create_dir(&next).unwrap();
    physics.run_to(3_000);
    let lost = physics.lost.last().unwrap().clone();
    assert!(lost.contains("no newer state is saved"), "{lost}");
    assert!(lost.contains("physics.state"), "{lost}");
    std::fs::remove_dir(&next).unwrap();
    physics.run_to(4_000);
    assert_eq!(physics.lost.last().unwrap(), "");
}

/// Does something to the file with these bytes.
type Damage<'a> = &'a dyn Fn(&[u8]);

#[test]
fn a_state_file_that_is_damaged_missing_or_a_link_is_reported() {
    let place = Place::new("damaged");
    let path = place.0.join("physics.state");
    let saved = |place: &Place| {
        place.start(false).run_to(2_000);
        std::fs::read(&path).unwrap()
    };
    let damage: [(&str, Damage<'_>); 4] = [
        ("cut off", &|_| std::fs::write(&path, b"abc").unwrap()),
        ("checksum", &|bytes| {
            let mut bytes = bytes.to_vec();
            *bytes.last_mut().unwrap() ^= 1;
            std::fs::write(&path, bytes).unwrap();
        }),
        ("missing", &|_| std::fs::remove_file(&path).unwrap()),
        ("symbolic link", &|_| {
            std::fs::remove_file(&path).unwrap();
            std::os::unix::fs::symlink("/etc/passwd", &path).unwrap();
        }),
    ];
    for (named, damage) in damage {
        damage(&saved(&place));
        let physics = place.start(true);
        let (tick, lost) = (physics.tick(), physics.resume.lost(physics.tick()));
        assert!(tick >= 1_000, "{named}: the state before is used: {tick}");
        assert!(lost.is_empty() || lost.contains(named), "{named}: {lost}");
        assert_eq!(lost.is_empty(), named == "missing", "{lost}");
        drop(physics);
        // Killed between the two renames of its first write.
        std::fs::rename(&path, path.with_extension("older")).ok();
        assert_eq!(place.start(true).tick(), tick, "{named}: it is still there");
        damage(&saved(&place));
        std::fs::write(path.with_extension("older"), b"abc").unwrap();
        let physics = place.start(true);
        assert_eq!(physics.tick(), 0);
        let lost = physics.resume.lost(0);
        assert!(lost.contains(named), "{named}: {lost}");
        assert!(lost.contains("the scene starts again"), "{lost}");
        std::fs::remove_file(&path).ok();
    }
}
