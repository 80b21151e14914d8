//! Jobs whose objects a person moves: put on, taken from and turned in their places, and pulled at
//! while the hand sets them down. Each ends done, or with the true reason.

mod places;
mod pulls;

use std::path::PathBuf;

use cell_model::cells::script::parse_for;
use cell_model::{Cell, Data};
use cell_run::summary::RunSummary;
use cell_sim::{OneProcess, eval};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// A run with a person in the cell.
struct Situation {
    name: &'static str,
    demo: &'static str,
    policy: &'static str,
    bins: u32,
    seed: u64,
    /// Objects that are elsewhere at the start: index, position (m), turn about x and z (rad).
    begin: Vec<(usize, [f64; 3], [f64; 2])>,
    script: String,
    /// Reasons with which it may fail.
    reasons: &'static [&'static str],
    /// Folder of the cell; that of the demos without one.
    data: Option<PathBuf>,
}

impl Situation {
    fn new(name: &'static str, demo: &'static str, policy: &'static str) -> Self {
        Self {
            name,
            demo,
            policy,
            bins: 0,
            seed: 1,
            begin: Vec::new(),
            script: String::new(),
            reasons: &[],
            data: None,
        }
    }

    fn bins(mut self, bins: u32) -> Self {
        self.bins = bins;
        self
    }

    fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// An object is there at the start.
    fn begin(mut self, object: usize, at_m: [f64; 3], turn: [f64; 2]) -> Self {
        self.begin.push((object, at_m, turn));
        self
    }

    /// It may end with one of these reasons.
    fn or(mut self, reasons: &'static [&'static str]) -> Self {
        self.reasons = reasons;
        self
    }

    /// A person pulls an object to a point (m).
    fn pull(mut self, at_s: f64, object: &str, to: [f64; 3], for_s: f64) -> Self {
        let line = format!(
            "{{\"at_s\": {at_s:.3}, \"do\": \"drag\", \"object\": \"{object}\", \
             \"to\": {to:?}, \"for_s\": {for_s:.3}}}\n"
        );
        self.script.push_str(&line);
        self
    }

    /// A person brings an object there from above.
    fn put(self, at_s: f64, object: &str, [x, y, z]: [f64; 3]) -> Self {
        self.pull(at_s, object, [x, y, z + 0.25], 4.0)
            .pull(at_s + 4.0, object, [x, y, z], 3.0)
    }

    /// Runs it to its end; the log, and its summary.
    fn run(&self) -> (Vec<String>, RunSummary) {
        let mut spec = eval::template(self.demo, self.policy);
        spec.seed = self.seed;
        spec.bins = (self.bins > 0).then_some(self.bins);
        spec.data_dir.clone_from(&self.data);
        let mut cell = spec.load_cell_from(&Data::checkout()).unwrap();
        spec.time_limit_s = Some(if self.demo.starts_with("ur10") {
            600.0
        } else {
            240.0
        });
        self.arrange(&mut cell);
        spec.script = parse_for(&self.script, "hands", &cell).unwrap();
        let mut sim = OneProcess::new(&demos::policies(), &spec, cell).unwrap();
        let mut lines = Vec::new();
        while sim.tick().unwrap() {
            let trace = sim.take_trace().into_iter();
            lines.extend(trace.map(|(tick, line)| format!("{:8.2} {line}", tick as f64 * 1.0e-3)));
        }
        (lines, sim.summary(&spec, 0.0))
    }

    fn arrange(&self, cell: &mut Cell) {
        for (object, at, [x, z]) in &self.begin {
            let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, *z)
                * UnitQuaternion::from_euler_angles(*x, 0.0, 0.0);
            let object = &mut cell.objects[*object];
            object.pose = Isometry3::from_parts(Translation3::from(*at), turn);
            object.parked = false;
        }
    }
}

/// Runs all and prints how each ended.
///
/// # Panics
/// Where one ends in another way than it may.
#[allow(clippy::print_stdout, reason = "a series says what it did")]
#[track_caller]
fn series(all: impl IntoIterator<Item = Situation>) {
    let only = std::env::var("ROBOCELL_SITUATION").unwrap_or_default();
    let mut wrong = Vec::new();
    for one in all.into_iter().filter(|one| one.name.contains(&only)) {
        let (lines, summary) = one.run();
        let reason = summary.reason.as_deref().unwrap_or("done");
        let text = format!(
            "{} {} seed {}: {reason} after {:.2} s",
            one.demo, one.name, one.seed, summary.sim_time_s
        );
        println!("{text}");
        let outcome = serde_json::to_value(summary.outcome).unwrap();
        let ended = outcome == "done" || outcome == "failed";
        let allowed = reason == "done" || one.reasons.contains(&reason);
        if !ended || !allowed || summary.script_left > 0 || !only.is_empty() {
            let script = &one.script;
            wrong.push(format!("{text}\n{script}{}", lines.join("\n")));
        }
        assert_eq!(summary.limit_violations, 0, "{text}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
