//! Recordings of episodes: what they hold, and that the recorded decisions give the recorded
//! states again.

use std::collections::BTreeMap;
use std::path::Path;

use cell_model::{Cell, Data};
use cell_record::{Channel, Recording};
use cell_run::spec::RunSpec;
use cell_sim::action::{Hold, action_of, decision_of};
use cell_sim::eval::{self, template};
use cell_sim::given::Decisions;
use cell_sim::{OneProcess, Program, episodes};
use controller_proc::Controllers;
use ipc_types::{Decision, WorldPiece};

/// Ticks of an action at 20 Hz.
const PERIOD: u64 = 50;

fn program() -> Program {
    crate::program()
}

/// Records one episode at 20 Hz; returns its recording.
fn record(dir: &Path, demo: &str, seed: u64) -> Recording {
    let cell = Cell::load(&Data::checkout(), demo, seed, None).unwrap();
    let spec = RunSpec {
        action_hz: Some(20),
        frame_hash: Vec::new(),
        policy_server: None,
        seed,
        arms: u8::try_from(cell.arms.len()).unwrap(),
        ..template(demo, &cell.default_policy)
    };
    let plan = eval::Plan {
        cases: episodes::cases(
            &program(),
            &spec,
            cell_model::cells::sweep::Sweep::default(),
        )
        .unwrap(),
        spec,
        seeds: seed..=seed,
        jobs: 1,
        record: Some(dir.to_owned()),
    };
    let summary = eval::evaluate(&program(), &plan, |_| {}).unwrap();
    assert_eq!(summary.done, 1, "{demo} seed {seed}");
    Recording::open(&dir.join(episodes::recording_name(seed, 0))).unwrap()
}

struct Episode {
    decisions: BTreeMap<u64, Decision>,
    /// Hash of the states up to that tick.
    hashes: BTreeMap<u64, u64>,
}

fn read(recording: &Recording) -> Episode {
    let mut episode = Episode {
        decisions: BTreeMap::new(),
        hashes: BTreeMap::new(),
    };
    for entry in recording.messages() {
        let entry = entry.unwrap();
        match entry.channel {
            Channel::Decision => {
                episode.decisions.insert(entry.tick, entry.read().unwrap());
            }
            Channel::World => {
                let piece: WorldPiece = entry.read().unwrap();
                assert_eq!(piece.all_objects, 1);
                episode.hashes.insert(entry.tick, piece.state_hash);
            }
            _ => {}
        }
    }
    episode
}

#[test]
fn a_recording_has_every_decision_and_a_state_for_each_action() {
    let dir = tempfile::tempdir().unwrap();
    let episode = read(&record(dir.path(), "cube", 1));
    let ticks = episode.decisions.keys().copied();
    assert!(ticks.eq((0..episode.decisions.len() as u64).map(|index| 10 * index)));
    let (end, _) = episode.hashes.last_key_value().unwrap();
    for tick in (0..=*end).step_by(50) {
        assert!(episode.hashes.contains_key(&tick), "{tick}");
    }
    for (tick, decision) in &episode.decisions {
        let action = &episode.decisions[&(tick - tick % PERIOD)].goals;
        assert_eq!(&decision.goals, action, "at {tick}");
        for number in decision.goals[0].target.position {
            assert_eq!(number.to_bits() << 35, 0, "at {tick}: {number}");
        }
    }
}

/// Asserts that a cell with these decisions has the recorded states.
fn gives_the_states(recording: &Recording, hashes: &BTreeMap<u64, u64>, decisions: Decisions) {
    let (end, _) = hashes.last_key_value().unwrap();
    let spec = recording.run();
    let cell = spec.load_cell_from(&Data::checkout()).unwrap();
    let mut sim = OneProcess::following(&Controllers::default(), spec, cell, decisions).unwrap();
    let mut equal = 0;
    loop {
        let (tick, hash) = (sim.state().header.tick, sim.state().state_hash);
        if let Some(recorded) = hashes.get(&tick) {
            assert_eq!(hash, *recorded, "{} at {tick}", spec.demo);
            equal += 1;
        }
        if tick == *end {
            break;
        }
        assert!(sim.tick().unwrap(), "{} ended at {tick}", spec.demo);
    }
    assert_eq!(equal, hashes.len());
}

#[test]
fn recorded_decisions_give_the_recorded_states_again() {
    let dir = tempfile::tempdir().unwrap();
    let recording = record(dir.path(), "franka-stack", 3);
    let Episode { decisions, hashes } = read(&recording);
    let decisions = Box::new(move |tick, decision: &mut Decision| *decision = decisions[&tick]);
    gives_the_states(&recording, &hashes, decisions);
}

#[test]
fn actions_alone_give_the_recorded_states_again() {
    for demo in ["cube", "franka-stack", "franka-pyramid"] {
        let dir = tempfile::tempdir().unwrap();
        let recording = record(dir.path(), demo, 5);
        let Episode { decisions, hashes } = read(&recording);
        let actions: BTreeMap<u64, Vec<_>> = decisions
            .iter()
            .filter(|(tick, _)| tick.is_multiple_of(PERIOD))
            .map(|(tick, decision)| {
                let goals = &decision.goals[..decision.arm_count as usize];
                (
                    *tick,
                    goals.iter().map(|goal| action_of(goal).unwrap()).collect(),
                )
            })
            .collect();
        let decide = move |tick: u64, decision: &mut Decision| {
            let actions: &Vec<_> = &actions[&(tick - tick % PERIOD)];
            *decision = decision_of(tick, actions, 20.0);
        };
        gives_the_states(&recording, &hashes, Box::new(decide));
    }
}

#[test]
fn an_episode_that_cannot_be_recorded_is_an_error_of_its_own() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("a file");
    std::fs::write(&file, "").unwrap();
    let spec = RunSpec {
        time_limit_s: Some(0.1),
        action_hz: Some(20),
        frame_hash: Vec::new(),
        policy_server: None,
        ..template("cube", "ifelse")
    };
    let cases = episodes::cases(
        &program(),
        &spec,
        cell_model::cells::sweep::Sweep::default(),
    )
    .unwrap();
    let plan = eval::Plan {
        spec,
        cases,
        seeds: 1..=2,
        jobs: 1,
        record: Some(file),
    };
    let errors = std::sync::Mutex::new(Vec::new());
    eval::evaluate(&program(), &plan, |ended| {
        let why = ended.result.clone().unwrap_err();
        errors.lock().unwrap().push(why);
    })
    .unwrap();
    let errors = errors.into_inner().unwrap();
    assert_eq!(errors.len(), 2);
    assert!(errors[0].starts_with("cannot record: "), "{}", errors[0]);
    assert!(Hold::new(30).is_err());
}
