//! Trees of two arms in files: what the policy itself does with them.

use std::path::PathBuf;
use std::sync::Arc;

use behavior::{Str, Value};
use cell_model::{Cell, Data};
use ipc_types::decision::Outcome;
use ipc_types::{ArmStatus, Decision, Header, Wire, WorldState};
use robocell_skills::files::{TreeJob, TreePolicy, TreeSource};
use robocell_skills::setup::Setup;
use robocell_task::{AnyPolicy as _, Job, Observation, Output, PolicyTime};

/// The left arm is in the zone for 50 ms, the right one does nothing.
const TREE: &str = r#"{
  "format": "behavior-tree/1", "name": "two", "constants": {"robot": "left"},
  "root": {"id": "job", "type": "Sequence", "children": [
    {"id": "enter", "type": "EnterZone", "name": "go in"},
    {"id": "stay", "type": "Stay", "name": "stay", "ports": {"for_s": 0.05}},
    {"id": "leave", "type": "LeaveZone", "name": "leave"}
  ]}
}"#;

/// A policy of two trees of that text, with its inputs and outputs.
struct Two {
    cell: Cell,
    policy: TreePolicy,
    state: Box<WorldState>,
    job: Job,
    out: Output,
    tick: u64,
    /// By arm: its controller answers.
    heard: [bool; 2],
    status: [ArmStatus; 2],
    lines: Vec<String>,
}

fn policy(cell: &Cell, test: &str, text: &str, once: bool) -> TreePolicy {
    let name = format!("robocell-skills-{test}-{}.json", std::process::id());
    let dir: PathBuf = std::env::temp_dir().join(format!("robocell-{test}-{}", std::process::id()));
    std::fs::create_dir_all(dir.join("cells")).unwrap();
    std::fs::write(dir.join("cells").join(&name), text).unwrap();
    let file = "cells/franka-pyramid.toml";
    let data = Data::dir(dir.clone()).with_robots_of(&Data::checkout());
    let toml = Data::checkout().read(file).unwrap().into_owned();
    let beside = Cell::from_text(&data, "two", file, &toml, 1, None).unwrap();
    let mut job = TreeJob::new(Arc::new(Setup::new(cell, [])));
    job.once = once;
    let source = TreeSource {
        file: name,
        board: "shared".to_owned(),
    };
    let policy = job.policy(&beside, &[source.clone(), source]).unwrap();
    std::fs::remove_dir_all(dir).unwrap();
    policy
}

impl Two {
    fn new(test: &str, once: bool) -> Self {
        let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
        let mut state = Box::new(WorldState::zeroed());
        state.arm_count = 2;
        Self {
            policy: policy(&cell, test, TREE, once),
            cell,
            state,
            job: Job::new(6),
            out: Output::default(),
            tick: 0,
            heard: [true; 2],
            status: [ArmStatus::zeroed(); 2],
            lines: Vec::new(),
        }
    }

    /// One decision; the phase that is shown.
    fn decide(&mut self) -> String {
        self.tick += 10;
        self.state.header = Header::caused_by::<WorldState>(self.tick);
        for (status, heard) in self.status.iter_mut().zip(self.heard) {
            if heard {
                status.header = Header::caused_by::<ArmStatus>(self.tick);
            }
        }
        let heard = [Some(&self.status[0]), Some(&self.status[1])];
        let time = PolicyTime::from_ticks(self.tick);
        let observation = Observation::new(&self.state, &heard, time);
        self.out.begin();
        self.policy
            .decide(&observation, &mut self.job, &mut self.out);
        let (mut decision, mut trace) = (Decision::zeroed(), Vec::new());
        self.out.finish(2, &mut decision, &mut trace);
        let people = trace.iter().filter(|line| line.kind.is_for_people());
        self.lines
            .extend(people.map(|line| line.text.as_str().to_owned()));
        decision.phase.as_str().to_owned()
    }

    fn owner(&self) -> String {
        let board = self.policy.board("shared").unwrap();
        match board.value(board.index("zone_owner").unwrap()) {
            Some(Value::Text(owner)) => owner.to_string(),
            other => panic!("{other:?}"),
        }
    }

    fn count(&self, part: &str) -> usize {
        self.lines.iter().filter(|line| line.contains(part)).count()
    }
}

#[test]
fn arms_take_turns_in_a_zone_and_each_does_its_part_once() {
    let mut two = Two::new("turns", true);
    let mut phases = Vec::new();
    let mut owners = Vec::new();
    while two.out.outcome != Outcome::Done && two.tick < 1000 {
        phases.push(two.decide());
        owners.push(two.owner());
    }
    assert!(two.tick < 1000, "{:?}", two.lines);
    phases.dedup();
    owners.dedup();
    assert_eq!(owners, ["left", "right", ""]);
    // The second entry of one decision is shown one decision later.
    let expected = [
        "LEFT_STAY",
        "RIGHT_GO_IN",
        "LEFT_LEAVE",
        "RIGHT_STAY",
        "RIGHT_LEAVE",
    ];
    assert_eq!(phases, expected);
    assert_eq!(two.job.counters.phase_entry, 5);
    assert_eq!(
        (two.count("[done] left"), two.count("[done] right")),
        (1, 1)
    );
    (0..20).for_each(|_| drop(two.decide()));
    assert_eq!(two.count("[done]"), 2, "not ticked again");
}

#[test]
fn a_zone_is_freed_when_its_owner_does_not_answer() {
    let mut two = Two::new("silent", true);
    two.decide();
    two.heard[0] = false;
    let mut decisions = 0;
    while two.owner() == "left" && decisions < 100 {
        // Its tree cannot reach the end of its stay.
        two.policy.reconcile(
            &Observation::new(&two.state, &[], PolicyTime::from_ticks(two.tick)),
            &mut two.job,
            &mut two.out,
        );
        two.decide();
        decisions += 1;
    }
    assert!((55..65).contains(&decisions), "{decisions}");
    assert_eq!(two.owner(), "right");
    assert_eq!(two.count("left does not answer, zone 'zone' is free"), 1);
}

#[test]
fn a_checkpoint_of_an_edited_file_says_what_is_lost() {
    let mut two = Two::new("edited", true);
    for _ in 0..3 {
        two.decide();
    }
    let saved = two.policy.save();
    let edited = TREE.replace("\"id\": \"enter\"", "\"id\": \"other\"");
    two.policy = policy(&two.cell, "edited", &edited, true);
    two.policy.restore(&saved).unwrap();
    two.decide();
    assert_eq!(
        two.count("2 nodes or keys of the checkpoint are not in the files"),
        1
    );
    let key = Value::Text(Str::new("left").unwrap());
    let board = two.policy.board("shared").unwrap();
    assert_eq!(board.value(board.index("zone_owner").unwrap()), Some(key));
    assert!(two.policy.restore(&saved[..saved.len() / 2]).is_err());
}
