//! SIGKILL of the task at random instants, in real time, watched from outside.
//!
//! `ROBOCELL_KILLS=N` asks for at least N kills over several runs; without it a
//! short sample is taken.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    reason = "a test fails by panicking, and a series says what it did"
)]

use std::collections::HashSet;
use std::fmt::Write as _;
use std::time::Duration;

use ipc_types::decision::{GoalKind, MAX_PLACED};
use ipc_types::topic::TopicId;
use ipc_types::{ArmGoal, Decision, GripperGoal, WorldState};
use robocell_tests::cell::{TestCell, base};

/// What is run, how long it takes at least (s), and where its stacks stand.
struct Job {
    demo: &'static str,
    policy: &'static str,
    lasts_s: f64,
    goals: &'static [[f64; 2]],
}

const JOBS: [Job; 3] = [
    Job {
        demo: "franka-pyramid",
        policy: "json",
        lasts_s: 18.0,
        goals: &[[0.46, -0.28], [0.46, 0.28]],
    },
    Job {
        demo: "franka-stack",
        policy: "bt",
        lasts_s: 25.0,
        goals: &[[0.55, 0.20]],
    },
    Job {
        demo: "franka-stack",
        policy: "fsm",
        lasts_s: 25.0,
        goals: &[[0.55, 0.20]],
    },
];
/// Kills of one run; they lie far enough apart that each hits another start of
/// the task.
const KILLS_PER_RUN: u64 = 8;
/// A cube this near to the axis of a stack and to the height of a layer is
/// where it belongs (m).
const AT_STACK_M: f64 = 0.03;
const AT_LAYER_M: f64 = 0.015;
const CUBE_M: f64 = 0.05;

/// Where the pyramid stands, up to the height at which a hand is clear of it:
/// who picks there owns the centre.
fn is_in_centre(goal: &ArmGoal) -> bool {
    let [x, y, z] = goal.target.position;
    goal.kind == GoalKind::Pose.code() && (x - 0.46).abs() < 0.12 && y.abs() < 0.1 && z < 0.2
}

/// One kill in each of equal parts of the job, at any millisecond of it.
fn script(lasts_s: f64, random_state: &mut u64) -> String {
    let part = lasts_s / KILLS_PER_RUN as f64;
    let mut text = String::new();
    for kill in 0..KILLS_PER_RUN {
        let at_s = 0.5 + part * (kill as f64 + 0.6 * robocell_tests::random(random_state));
        let line = format!(r#"{{"at_s": {at_s:.3}, "do": "kill", "process": "task"}}"#);
        writeln!(text, "{line}").expect("text grows");
    }
    text
}

/// What was seen from outside.
#[derive(Default)]
struct Witness {
    decisions: u64,
    generations: HashSet<u32>,
}

impl Witness {
    /// A gripper that is told to open has nothing in it, or stands where its
    /// cube belongs; no cube is counted twice; one arm at most picks in the
    /// centre.
    fn see(&mut self, decision: &Decision, state: &WorldState, goals: &[[f64; 2]]) {
        self.decisions += 1;
        self.generations.insert(decision.header.generation);
        let placed = &decision.placed[..(decision.placed_count as usize).min(MAX_PLACED)];
        let distinct: HashSet<&u32> = placed.iter().collect();
        assert_eq!(distinct.len(), placed.len(), "counted twice: {placed:?}");
        let inside = decision.goals[..state.arms().len()].iter();
        let inside = inside.filter(|goal| is_in_centre(goal)).count();
        assert!(
            inside <= 1,
            "two arms in the centre, tick {}",
            decision.header.tick
        );
        for (goal, arm) in decision.goals.iter().zip(state.arms()) {
            let opens = goal.gripper == GripperGoal::Open.code();
            let held = (arm.gripper.held_object as usize).checked_sub(1);
            let (true, Some(object)) = (opens, held) else {
                continue;
            };
            let [x, y, z] = state.objects()[object].pose.position;
            let at_stack = goals
                .iter()
                .any(|[gx, gy]| (x - gx).hypot(y - gy) < AT_STACK_M)
                && ((z / CUBE_M).fract() - 0.5).abs() * CUBE_M < AT_LAYER_M;
            assert!(
                at_stack,
                "{} lets go of object {object} at {x:.3} {y:.3} {z:.3}, tick {}",
                decision.phase, decision.header.tick
            );
        }
    }
}

fn run(job: &Job, seed: u64, random_state: &mut u64) -> u64 {
    let dir = base();
    let file = dir.path().join("kills.jsonl");
    std::fs::write(&file, script(job.lasts_s, random_state)).expect("the script is written");
    let (file, seed) = (file.display().to_string(), seed.to_string());
    let mut cell = TestCell::start_in(
        dir,
        &[
            job.demo,
            "--policy",
            job.policy,
            "--seed",
            &seed,
            "--headless",
            "--until-done",
            "--json",
            "--script",
            &file,
        ],
    );
    let mut witness = Witness::default();
    watch(&mut cell, job, &mut witness);
    let said = cell.wait_end();
    assert_eq!(said.code, 0, "{said:?}");
    let summary = said.json();
    let kills = summary["task_restarts"].as_u64().expect("a number");
    println!(
        "{} {}: {kills} kills, {} decisions of {} starts seen, {} cycles missed, {} limit violations",
        job.demo,
        job.policy,
        witness.decisions,
        witness.generations.len(),
        summary["missed_cycles"],
        summary["limit_violations"]
    );
    assert_eq!(summary["outcome"], "done", "{summary}");
    assert_eq!(summary["drops"], 0, "{summary}");
    assert_eq!(summary["limit_violations"], 0, "{summary}");
    assert!(witness.generations.len() > 1, "nothing was seen");
    assert_eq!(kills, KILLS_PER_RUN, "{summary}");
    kills
}

/// Looks at every decision until the cell ends.
fn watch(cell: &mut TestCell, job: &Job, witness: &mut Witness) {
    cell.wait_up();
    let bus = cell.join();
    let mut decisions = bus
        .latest::<Decision>(TopicId::Decision)
        .expect("decisions");
    let mut states = bus
        .latest::<WorldState>(TopicId::WorldState)
        .expect("states");
    while cell.is_running() {
        states.refresh();
        if decisions.refresh()
            && let (Some(decision), Some(state)) = (decisions.get(), states.get())
        {
            witness.see(decision, state, job.goals);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn let_nothing_fall_and_count_nothing_twice() {
    let asked = std::env::var("ROBOCELL_KILLS").ok();
    let wanted = asked.and_then(|n| n.parse().ok()).unwrap_or(1);
    let mut random_state = 20_261_121;
    let (mut kills, mut seed) = (0, 1);
    while kills < wanted {
        for job in &JOBS[..if wanted > 1 { JOBS.len() } else { 1 }] {
            kills += run(job, seed, &mut random_state);
        }
        seed += 1;
    }
    println!("{kills} kills in all");
}
