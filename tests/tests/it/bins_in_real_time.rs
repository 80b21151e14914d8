//! The UR10 cells in real time, with the task killed at random instants: the job
//! is done, no bin falls, none is counted twice, and the recording can be
//! computed again.
//!
//! `ROBOCELL_KILLS=N` asks for at least N kills over several runs of all three;
//! without it one short job is a sample.

#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a test fails by panicking, and a series says what it did"
)]

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use ipc_types::decision::MAX_PLACED;
use ipc_types::topic::TopicId;
use ipc_types::{Decision, WorldState};
use robocell_tests::cell::{TestCell, base};
use robocell_tests::recording::{same, verify};
use serde_json::Value;

/// A job, with the shortest time that it can take (s).
struct Job {
    demo: &'static str,
    bins: Option<&'static str>,
    seed: &'static str,
    lasts_s: f64,
    /// Held bins that are meant to break off.
    drops: u64,
    /// How far a bin that was let go may sink (m): it tilts in the jig.
    sinks_m: f64,
}

/// Straight onto its column; over the station; over the jig; straight onto the
/// pallet; filled until it breaks off.
const JOBS: [Job; 5] = [
    Job {
        demo: "ur10-bin-stack",
        bins: Some("1"),
        seed: "2",
        lasts_s: 20.0,
        drops: 0,
        sinks_m: 0.03,
    },
    Job {
        demo: "ur10-bin-stack",
        bins: Some("1"),
        seed: "1",
        lasts_s: 36.0,
        drops: 0,
        sinks_m: 0.03,
    },
    Job {
        demo: "ur10-palletize",
        bins: Some("1"),
        seed: "2",
        lasts_s: 33.0,
        drops: 0,
        sinks_m: 0.2,
    },
    Job {
        demo: "ur10-palletize",
        bins: Some("1"),
        seed: "1",
        lasts_s: 18.0,
        drops: 0,
        sinks_m: 0.03,
    },
    Job {
        demo: "ur10-fill-bin",
        bins: None,
        seed: "2",
        lasts_s: 24.0,
        drops: 1,
        sinks_m: f64::INFINITY,
    },
];
/// Kills of one run.
const KILLS_PER_RUN: u64 = 3;
/// A bin that was let go is looked after for this long (ticks).
const LOOKED_AFTER_TICKS: u64 = 1_000;

/// One kill in each of equal parts of the job, at any millisecond of it.
fn script(lasts_s: f64, random_state: &mut u64) -> String {
    let part = lasts_s / KILLS_PER_RUN as f64;
    let mut text = String::new();
    for kill in 0..KILLS_PER_RUN {
        let at_s = 0.2 + part * (kill as f64 + 0.8 * robocell_tests::random(random_state));
        let line = format!(r#"{{"at_s": {at_s:.3}, "do": "kill", "process": "task"}}"#);
        writeln!(text, "{line}").expect("text grows");
    }
    text
}

/// What was seen from outside.
#[derive(Default)]
struct Witness {
    generations: HashSet<u32>,
    held: Option<usize>,
    /// Object, its height (m) and the tick when it was let go.
    let_go: Option<(usize, f64, u64)>,
}

impl Witness {
    fn see_decision(&mut self, decision: &Decision) {
        self.generations.insert(decision.header.generation);
        let placed = &decision.placed[..(decision.placed_count as usize).min(MAX_PLACED)];
        let distinct: HashSet<&u32> = placed.iter().collect();
        assert_eq!(distinct.len(), placed.len(), "counted twice: {placed:?}");
    }

    /// A bin that was let go stays about where it is.
    fn see_state(&mut self, state: &WorldState, sinks_m: f64) {
        let tick = state.header.tick;
        let height = |object: usize| state.objects()[object].pose.position[2];
        let gripper = &state.arms()[0].gripper;
        let held = (gripper.held_object as usize).checked_sub(1);
        if let (Some(object), None) = (self.held, held) {
            self.let_go = Some((object, height(object), tick));
        }
        self.held = held;
        if let Some((object, from_m, since)) = self.let_go {
            if tick > since + LOOKED_AFTER_TICKS || held == Some(object) {
                self.let_go = None;
                return;
            }
            let sunk_m = from_m - height(object);
            assert!(
                sunk_m < sinks_m,
                "object {object} fell {sunk_m:.3} m, tick {tick}"
            );
        }
    }
}

/// Looks at every decision and most states until the cell ends.
fn watch(cell: &mut TestCell, job: &Job) -> Witness {
    cell.wait_up();
    let bus = cell.join();
    let mut decisions = bus
        .latest::<Decision>(TopicId::Decision)
        .expect("decisions");
    let mut states = bus
        .latest::<WorldState>(TopicId::WorldState)
        .expect("states");
    let mut witness = Witness::default();
    while cell.is_running() {
        if states.refresh()
            && let Some(state) = states.get()
        {
            witness.see_state(state, job.sinks_m);
        }
        if decisions.refresh()
            && let Some(decision) = decisions.get()
        {
            witness.see_decision(decision);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    witness
}

fn run(job: &Job, random_state: &mut u64) -> u64 {
    let dir = base();
    let path = |name: &str| dir.path().join(name).display().to_string();
    let (script_file, recording) = (path("kills.jsonl"), path("run.mcap"));
    let kills = script(job.lasts_s, random_state);
    std::fs::write(&script_file, kills).expect("the script is written");
    let bins = job.bins.map(|bins| ["--bins", bins]);
    let fixed = [
        job.demo,
        "--seed",
        job.seed,
        "--headless",
        "--until-done",
        "--json",
        "--script",
        &script_file,
        "--record",
        &recording,
    ];
    let arguments: Vec<&str> = fixed
        .into_iter()
        .chain(bins.into_iter().flatten())
        .collect();
    let mut cell = TestCell::start_in(dir, &arguments);
    let witness = watch(&mut cell, job);
    let said = cell.wait_end();
    assert_eq!(said.code, 0, "{said:?}");
    let summary = said.json();
    check(job, &summary, &witness);
    let report = same(&verify(cell.base(), Path::new(&recording), &["--json"]));
    assert!(
        report["decisions"]["compared"].as_u64() > Some(0),
        "{report}"
    );
    summary["task_restarts"].as_u64().expect("a number")
}

fn check(job: &Job, summary: &Value, witness: &Witness) {
    println!(
        "{} {}: {} kills, {} s, {} starts seen, {} cycles missed, {} recoveries",
        job.demo,
        job.seed,
        summary["task_restarts"],
        summary["sim_time_s"],
        witness.generations.len(),
        summary["missed_cycles"],
        summary["recoveries"]
    );
    assert_eq!(summary["outcome"], "done", "{summary}");
    assert_eq!(summary["drops"], job.drops, "{summary}");
    assert_eq!(summary["limit_violations"], 0, "{summary}");
    assert_eq!(summary["script_left"], 0, "{summary}");
    // A start that takes long on a busy machine is begun again.
    assert!(
        summary["task_restarts"].as_u64() >= Some(KILLS_PER_RUN),
        "{summary}"
    );
    let placed = summary["placed"].as_array().map(Vec::len);
    let wanted = job.bins.map_or(0, |bins| bins.parse().expect("a number"));
    assert_eq!(placed, Some(wanted), "{summary}");
    assert!(witness.generations.len() > 1, "nothing was seen");
}

#[test]
fn are_handled_by_a_task_that_is_killed_again_and_again() {
    let asked = std::env::var("ROBOCELL_KILLS").ok();
    let wanted = asked.and_then(|n| n.parse().ok()).unwrap_or(1);
    let mut random_state = 20_261_122;
    let mut kills = 0;
    while kills < wanted {
        for job in &JOBS[..if wanted > 1 { JOBS.len() } else { 1 }] {
            kills += run(job, &mut random_state);
        }
    }
    println!("{kills} kills in all");
}
