//! One small job in six ways: all of them end alike, undisturbed, disturbed, and
//! killed at every decision.

use cell_run::spec::RunSpec;
use cell_sim::{OneProcess, eval};
use ipc_types::DECISION_TICKS;
use ipc_types::decision::Outcome;

const POLICIES: [&str; 6] = ["ifelse", "fsm", "tree", "json", "table", "matrix"];
/// Where the cube ends (m).
const MARK: [f64; 3] = [0.50, 0.25, 0.025];
/// Where the tool ends: above it (m).
const TOOL: [f64; 3] = [0.50, 0.25, 0.125];

/// The cube is pulled out of the gripper, and later off the mark.
const PULLS: &str = r#"
{"at_s": 3.6, "do": "drag", "object": "cube", "to": [0.45, -0.10, 0.025]}
{"at_s": 15.0, "do": "drag", "object": "cube", "to": [0.55, 0.05, 0.025]}
"#;

struct Run {
    sim: OneProcess,
    restarts: bool,
    trace: Vec<String>,
    /// Names of the phases, one after the other.
    phases: Vec<String>,
}

impl Run {
    fn new(policy: &str, script: &str) -> Self {
        let mut spec: RunSpec = eval::template("cube", policy);
        spec.seed = 3;
        spec.until_done = false;
        spec.script = cell_model::cells::script::parse(script, "script").unwrap();
        let cell = spec.load_cell_from(&cell_model::Data::checkout()).unwrap();
        Self {
            sim: OneProcess::new(&demos::policies(), &spec, cell).unwrap(),
            restarts: false,
            trace: Vec::new(),
            phases: Vec::new(),
        }
    }

    fn until(&mut self, seconds: f64) {
        while (self.sim.state().header.tick as f64) < seconds * 1.0e3 {
            assert!(self.sim.tick().unwrap(), "the run ended");
            let lines = self.sim.take_trace();
            self.trace.extend(lines.into_iter().map(|(_, line)| line));
            let phase = self.sim.decision().phase;
            if !phase.is_empty() && self.phases.last().is_none_or(|last| last != phase.as_str()) {
                self.phases.push(phase.as_str().to_owned());
            }
            if self.restarts && self.sim.state().header.tick.is_multiple_of(DECISION_TICKS) {
                self.sim.restart_task().unwrap();
            }
        }
    }

    /// The job is done, with cube and tool where they belong.
    fn assert_done(&self, what: &str) {
        let outcome = Outcome::from_code(self.sim.decision().outcome);
        assert_eq!(outcome, Some(Outcome::Done), "{what}: {:#?}", self.trace);
        let state = self.sim.state();
        let near = |is: [f64; 3], wanted: [f64; 3], tolerance: f64| {
            let off = is.iter().zip(wanted).map(|(a, b)| (a - b).powi(2));
            assert!(off.sum::<f64>().sqrt() < tolerance, "{what}: {is:?}");
        };
        near(state.objects()[0].pose.position, MARK, 0.006);
        near(state.arms()[0].tcp.position, TOOL, 0.025);
        assert_eq!(self.sim.decision().placed_count, 1, "{what}");
    }
}

#[test]
fn every_way_puts_the_cube_on_the_mark() {
    for policy in POLICIES {
        let mut run = Run::new(policy, "");
        run.until(10.0);
        run.assert_done(policy);
        // `nth` of a script counts phases, not the motions within one.
        let entries = run.sim.decision().phase_entry as usize;
        assert_eq!(entries, run.phases.len(), "{policy}: {:?}", run.phases);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn every_way_recovers_when_the_cube_is_taken() {
    for policy in POLICIES {
        let mut run = Run::new(policy, PULLS);
        run.until(14.9);
        run.assert_done(&format!("{policy}, out of the gripper"));
        assert!(run.sim.decision().drops > 0, "{policy}: it was held");
        run.until(17.5);
        let outcome = Outcome::from_code(run.sim.decision().outcome);
        assert_eq!(outcome, Some(Outcome::Running), "{policy}: taken");
        run.until(28.0);
        run.assert_done(&format!("{policy}, off the mark"));
    }
}

/// The task is killed at every decision until `end` (s), or never: the same hash.
fn assert_unnoticed(policy: &str, script: &str, end: f64) {
    let mut hashes = [false, true].into_iter().map(|restarts| {
        let mut run = Run::new(policy, script);
        run.restarts = restarts;
        run.until(end);
        run.sim.state().state_hash
    });
    assert_eq!(hashes.next(), hashes.next(), "{policy} {script}");
}

#[test]
fn no_way_notices_that_its_task_is_killed_at_every_decision() {
    for policy in POLICIES {
        assert_unnoticed(policy, "", 8.0);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn nor_while_the_cube_is_taken_away() {
    for policy in POLICIES {
        assert_unnoticed(policy, PULLS, 26.0);
    }
}

/// The cube is pulled off the table before the arm is at it.
const FALL: &str = r#"
{"at_s": 1.0, "do": "drag", "object": "cube", "to": [0.5, -1.3, 0.15], "for_s": 3}
"#;

fn checkout(path: &str) -> String {
    std::fs::read_to_string(cell_model::Data::checkout_dir().join(path)).unwrap()
}

/// The code blocks of docs/choosing.md in that language.
fn blocks<'d>(guide: &'d str, language: &str) -> Vec<&'d str> {
    let start = format!("```{language}\n");
    let parts = guide.split(start.as_str()).skip(1);
    parts
        .map(|part| part.split("```").next().unwrap())
        .collect()
}

/// A file of the checkout, and its text with the changes of a diff.
fn changed(diff: &str) -> (String, String) {
    let (head, hunks) = diff.split_once("\n@@\n").unwrap();
    let file = head.strip_prefix("--- ").unwrap();
    let mut text = checkout(file);
    for hunk in hunks.split("\n@@\n") {
        let side = |other: char| {
            let lines = hunk.lines().filter(|line| !line.starts_with(other));
            lines.fold(String::new(), |all, line| {
                all + line.get(1..).unwrap_or_default() + "\n"
            })
        };
        let (before, after) = (side('+'), side('-'));
        assert_eq!(text.matches(&before).count(), 1, "{file}: {before}");
        text = text.replacen(&before, &after, 1);
    }
    (file.to_owned(), text)
}

#[test]
fn the_guide_has_the_length_of_each_of_the_six_files() {
    let guide = checkout("docs/choosing.md");
    let in_files = ["cube.tree.json", "cube.machine.toml", "cube.matrix.toml"];
    let in_rust = ["ifelse.rs", "fsm.rs", "tree.rs"];
    for file in in_rust.iter().chain(&in_files) {
        let lines = checkout(&format!("cells/cube/{file}")).lines().count();
        assert!((40..=120).contains(&lines), "{file}: {lines}");
        let row = format!("[`{file}`](../cells/cube/{file}) | {lines} |");
        assert!(guide.contains(&row), "{row}");
    }
}

#[test]
fn the_new_rule_of_the_guide_fits_all_files_and_is_obeyed_by_those_without_a_compiler() {
    let guide = checkout("docs/choosing.md");
    let diffs = blocks(&guide, "diff");
    assert_eq!(diffs.len(), 6);
    let dir = std::env::temp_dir().join(format!("robocell-choosing-{}", std::process::id()));
    std::fs::create_dir_all(dir.join("cells/cube")).unwrap();
    std::fs::write(dir.join("cells/cube.toml"), checkout("cells/cube.toml")).unwrap();
    for diff in diffs {
        let (file, text) = changed(diff.trim_end());
        std::fs::write(dir.join(file), text).unwrap();
    }
    for policy in ["json", "table", "matrix"] {
        let mut spec: RunSpec = eval::template("cube", policy);
        spec.script = cell_model::cells::script::parse(FALL, "script").unwrap();
        spec.data_dir = Some(dir.clone());
        let program = crate::program();
        let summary = cell_sim::run::to_the_end(&program, &spec, |_| {}).unwrap();
        assert_eq!(
            format!("{:?}", summary.outcome),
            "Done",
            "{policy}: {summary:?}"
        );
        assert!(summary.placed.is_empty(), "{policy}");
    }
    std::fs::remove_dir_all(&dir).ok();
}

#[test]
fn an_end_is_told_once_and_again_after_the_cube_was_taken_off_its_mark() {
    for policy in POLICIES {
        let pull = r#"{"at_s": 12.0, "do": "drag", "object": "cube", "to": [0.55, 0.05, 0.025]}"#;
        let mut run = Run::new(policy, pull);
        let mut ends = Vec::new();
        let mut was_done = false;
        for tick in 0..24_000_u32 {
            run.until(f64::from(tick) * 1.0e-3);
            let is_done = run.sim.decision().outcome == Outcome::Done.code();
            if is_done && !was_done {
                ends.push(tick);
            }
            was_done = is_done;
        }
        assert_eq!(ends.len(), 2, "{policy}: {ends:?}");
        assert!(ends[0] < 12_000 && 12_000 < ends[1], "{policy}: {ends:?}");
        let told = run.trace.iter().filter(|line| line.contains("[done]"));
        assert!(matches!(told.count(), 0 | 2), "{policy}: {:#?}", run.trace);
    }
}
