//! Bins off the conveyor into columns: those that open downward directly, those
//! that open upward over the flipping station.

use cell_sim::{OneProcess, eval::template};
use ipc_types::Pose;
use ipc_types::decision::Outcome;
use ipc_types::world::OBJECT_TOUCHED;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

struct Run {
    sim: OneProcess,
    lines: Vec<String>,
    /// The bin that was held last, plus 1.
    last_held: u32,
}

impl Run {
    /// `flipped`: the share of bins that come upside down.
    fn new(seed: u64, bins: u32, flipped: Option<f64>, script: &str) -> Self {
        let mut spec = template("ur10-bin-stack", "matrix");
        spec.seed = seed;
        spec.bins = Some(bins);
        spec.time_limit_s = Some(120.0 + 60.0 * f64::from(bins));
        spec.script = cell_model::cells::script::parse(script, "script").expect("a script");
        let mut cell = spec
            .load_cell_from(&cell_model::Data::checkout())
            .expect("the built-in cell");
        if let (Some(share), Some(conveyor)) = (flipped, &mut cell.conveyor) {
            let supply = conveyor.supply.as_mut().expect("a supply");
            supply.flipped_share = share;
        }
        let sim = OneProcess::new(&demos::policies(), &spec, cell).expect("a cell that runs");
        Self {
            sim,
            lines: Vec::new(),
            last_held: 0,
        }
    }

    /// To the end, which has to be `bins` bins in place.
    #[track_caller]
    fn finish(mut self, bins: u32) -> Self {
        while self.sim.tick().expect("a tick") {
            let trace = self.sim.take_trace().into_iter();
            self.lines.extend(trace.map(|(_, line)| line));
            self.check_touched();
        }
        let decision = self.sim.decision();
        let outcome = Outcome::from_code(decision.outcome);
        assert_eq!(outcome, Some(Outcome::Done), "{:#?}", self.lines);
        assert_eq!(decision.placed_count, bins, "{:#?}", self.lines);
        let arm = &self.sim.state().arms()[0];
        assert_eq!((arm.limit_violations, decision.drops), (0, 0));
        self
    }

    /// The arm touches no placed bin except the one that it released last.
    #[track_caller]
    fn check_touched(&mut self) {
        let state = self.sim.state();
        let held = state.arms()[0].gripper.held_object;
        if held > 0 {
            self.last_held = held;
        }
        let decision = self.sim.decision();
        for index in &decision.placed[..decision.placed_count as usize] {
            let touched = state.objects()[*index as usize].flags & OBJECT_TOUCHED != 0;
            let tick = state.header.tick;
            assert!(
                !touched || self.last_held == index + 1,
                "bin {} at tick {tick}: {:#?}",
                index + 1,
                self.lines
            );
        }
    }

    fn count(&self, part: &str) -> usize {
        self.lines.iter().filter(|l| l.contains(part)).count()
    }
}

/// Height of the bin's own z axis: -1 upside down.
fn up(pose: &Pose) -> f64 {
    let [w, x, y, z] = pose.orientation_wxyz;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    (rotation * Vector3::z()).z
}

#[test]
fn a_bin_that_opens_downward_goes_straight_to_its_column() {
    let run = Run::new(1, 1, Some(1.0), "").finish(1);
    assert_eq!(
        (run.count("[decide] -> flip"), run.count("[placed]")),
        (0, 1)
    );
    let bin = run.sim.state().objects()[0].pose;
    let [x, y, z] = bin.position;
    assert!(
        (x - 0.95).abs() < 0.003 && (y + 0.63).abs() < 0.003,
        "{x} {y}"
    );
    assert!((z + 0.3825).abs() < 0.002, "{z}");
    assert!(up(&bin) < -0.9999);
}

#[test]
fn a_bin_that_opens_upward_is_turned_over_and_gripped_again_on_the_way() {
    let run = Run::new(1, 1, Some(0.0), "").finish(1);
    assert_eq!(run.count("[decide] -> flip"), 1, "{:#?}", run.lines);
    assert_eq!(run.count("again from its bottom"), 1);
    assert!(up(&run.sim.state().objects()[0].pose) < -0.9999);
}

#[test]
fn killed_again_and_again_and_with_a_bin_added_both_kinds_end_upside_down() {
    let kills = (1..12).map(|k| {
        let at = 4.3 * f64::from(k);
        format!("{{\"at_s\": {at}, \"do\": \"kill\", \"process\": \"task\"}}\n")
    });
    let script: String = kills
        .chain(["{\"at_s\": 6.0, \"do\": \"add_bin\"}\n".to_owned()])
        .collect();
    let run = Run::new(2, 3, None, &script).finish(3);
    assert_eq!(run.sim.task_restarts(), 11);
    let bins = &run.sim.state().objects()[..3];
    for bin in bins {
        assert!(up(&bin.pose) < -0.9999);
    }
    let [x, y, _] = bins[0].pose.position;
    for bin in bins {
        let [bx, by, _] = bin.pose.position;
        assert!((bx - x).hypot(by - y) < 0.003, "a straight column");
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_column_of_four_stands_still() {
    let mut spec = template("ur10-bin-stack", "matrix");
    spec.seed = 3;
    spec.bins = Some(4);
    spec.until_done = false;
    let start = "{\"at_s\": 0.5, \"do\": \"task_start\"}";
    spec.script = cell_model::cells::script::parse(start, "script").expect("a script");
    let cell = spec
        .load_cell_from(&cell_model::Data::checkout())
        .expect("the built-in cell");
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell).expect("a cell that runs");
    let done = |sim: &OneProcess| sim.decision().outcome == Outcome::Done.code();
    while !done(&sim) && sim.state().header.tick < 240_000 {
        sim.tick().expect("a tick");
    }
    assert!(done(&sim));
    let before: Vec<Pose> = sim.state().objects()[..4].iter().map(|o| o.pose).collect();
    for _ in 0..10_000 {
        sim.tick().expect("a tick");
    }
    for (pose, now) in before.iter().zip(sim.state().objects()) {
        let drift = Vector3::from(pose.position) - Vector3::from(now.pose.position);
        assert!(drift.norm() < 1.0e-3, "{} m in 10 s", drift.norm());
    }
}

/// A script: in `phase` the operator takes the arm over, leads it to two poses, given
/// by position and directed angle of the cup, and gives it back.
fn leading(phase: &str, after_s: f64, poses: [([f64; 3], [f64; 4]); 2]) -> String {
    let line = |after_s: f64, rest: &str| {
        format!("{{\"at_phase\":\"{phase}\",\"after_s\":{after_s},\"do\":{rest}}}\n")
    };
    let mut script = line(after_s, "\"task_pause\"");
    for ((position, [w, x, y, z]), at) in poses.into_iter().zip([0.5, 4.5]) {
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let [x, y, z, w]: [f64; 4] = turn.coords.into();
        let target =
            format!("\"target\",\"position\":{position:?},\"orientation_wxyz\":[{w},{x},{y},{z}]");
        script += &line(after_s + at, &target);
    }
    script + &line(after_s + 8.5, "\"task_resume\"")
}

/// The cup turned by a quarter, and far around: from there a path of poses ended with
/// a joint at its limit, three times, and the job failed.
#[test]
fn an_arm_the_operator_wound_up_is_restored_before_the_bin_is_placed() {
    let poses = [
        ([0.115, 0.755, 0.558], [0.46067, 0.53646, 0.46067, -0.53646]),
        ([0.636, 0.219, 0.506], [0.11689, 0.69738, 0.11689, -0.69738]),
    ];
    let run = Run::new(4, 2, None, &leading("PLACING", 0.949, poses)).finish(2);
    assert_eq!(run.count("[resume] bin_01"), 1, "{:#?}", run.lines);
    assert_eq!(run.count("[timeout]"), 0, "{:#?}", run.lines);
}

/// Led into its own base with a bin on the cup, the arm was blocked, and pressed
/// against what blocked it for as long as the run lasted.
#[test]
#[ignore = "slow: .ci/long"]
fn an_arm_the_operator_jammed_frees_itself_and_works_again() {
    let poses = [
        (
            [-0.041, -0.898, 0.349],
            [0.48847, 0.51127, 0.48847, -0.51127],
        ),
        (
            [0.632, -0.698, 0.566],
            [0.65978, -0.25435, 0.65978, 0.25435],
        ),
    ];
    let mut run = Run::new(1, 2, None, &leading("FLIPPING", 1.3948, poses));
    while run.sim.tick().expect("a tick") {}
    // The bin it was jammed with may end up leaning somewhere.
    assert!(run.sim.decision().placed_count >= 1);
    assert_eq!(run.sim.state().arms()[0].limit_violations, 0);
}

#[test]
fn a_target_without_orientation_keeps_the_cup_as_it_is() {
    let script = "{\"at_s\":1,\"do\":\"task_pause\"}\n\
                  {\"at_s\":1.5,\"do\":\"target\",\"position\":[0.3,0.6,0.5]}\n";
    let mut run = Run::new(1, 1, None, script);
    let pose_at = |run: &mut Run, tick: u64| {
        while run.sim.state().header.tick < tick && run.sim.tick().expect("a tick") {}
        run.sim.state().arms()[0].tcp
    };
    let turn = |pose: &Pose| {
        let [w, x, y, z] = pose.orientation_wxyz;
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
    };
    let (before, after) = (pose_at(&mut run, 1_500), pose_at(&mut run, 6_000));
    let (angle, off) = (
        turn(&before).angle_to(&turn(&after)),
        Vector3::from(after.position) - Vector3::new(0.3, 0.6, 0.5),
    );
    assert!(angle < 0.05 && off.norm() < 0.02, "{angle} rad, {off}");
}
