//! A bin is filled until suction releases it, falls, spills, is found and held again.

use cell_model::{Cell, Shape};
use cell_run::spec::RunSpec;
use cell_sim::{OneProcess, eval::template};
use ipc_types::decision::Outcome;
use ipc_types::equipment::{BreakCause, BreakLimit};
use ipc_types::world::OBJECT_ENABLED;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

const BIN: usize = 0;
/// The floor, and how high the bin is held (m).
const FLOOR_M: f64 = -0.59;
const HELD_M: f64 = 0.3;
/// Thickness of a plate that holds a bin up (m).
const PLATE_M: f64 = 0.02;
/// Between two kills of the task, where it is killed: no multiple of anything.
const KILL_TICKS: u64 = 490;

fn spec(seed: u64, script: &str) -> RunSpec {
    let mut spec = template("ur10-fill-bin", "matrix");
    spec.seed = seed;
    spec.time_limit_s = Some(90.0);
    spec.script = cell_model::cells::script::parse(script, "script").unwrap();
    spec
}

struct Run {
    sim: OneProcess,
    lines: Vec<String>,
    /// Smallest distance of the arm from an obstacle (m).
    clearance: f64,
    /// Whether the task is killed again and again.
    restarts: bool,
}

impl Run {
    fn new(spec: &RunSpec) -> Self {
        Self::of(
            spec,
            spec.load_cell_from(&cell_model::Data::checkout()).unwrap(),
        )
    }

    fn of(spec: &RunSpec, cell: Cell) -> Self {
        Self {
            sim: OneProcess::new(&demos::policies(), spec, cell).unwrap(),
            lines: Vec::new(),
            clearance: f64::INFINITY,
            restarts: false,
        }
    }

    fn tick(&mut self) -> bool {
        let goes_on = self.sim.tick().unwrap();
        if self.restarts && self.sim.state().header.tick.is_multiple_of(KILL_TICKS) {
            self.sim.restart_task().unwrap();
        }
        let trace = self.sim.take_trace().into_iter();
        self.lines.extend(trace.map(|(_, line)| line));
        self.clearance = self.clearance.min(self.sim.statuses()[0].min_clearance);
        goes_on
    }

    fn finish(mut self) -> Self {
        while self.tick() {}
        self
    }

    fn outcome(&self) -> Option<Outcome> {
        Outcome::from_code(self.sim.decision().outcome)
    }

    fn bin_height(&self) -> f64 {
        self.sim.state().objects()[BIN].pose.position[2]
    }

    /// Number of parts on the floor.
    fn spilled(&self) -> usize {
        let parts = self.sim.state().objects().iter().skip(1);
        let here = parts.filter(|part| part.flags & OBJECT_ENABLED != 0);
        let low = here.filter(|part| part.pose.position[2] < FLOOR_M + 0.1);
        low.count()
    }
}

#[test]
fn the_bin_is_filled_until_it_falls_and_held_again() {
    let run = Run::new(&spec(1, "")).finish();
    let (state, decision) = (run.sim.state(), run.sim.decision());
    assert_eq!(run.outcome(), Some(Outcome::Done), "{:#?}", run.lines);
    let gripper = &state.arms()[0].gripper;
    assert_eq!((gripper.breaks, gripper.held_object), (1, 1));
    assert_ne!(gripper.break_limit, BreakLimit::None.code());
    assert_ne!(gripper.break_cause, BreakCause::None.code());
    assert_eq!(decision.drops, 1);
    assert!(run.bin_height() > HELD_M, "{}", run.bin_height());
    let dropped = state.equipment.parts_dropped;
    assert!(dropped >= 20, "it broke after {dropped} parts");
    assert!(run.spilled() > 5, "{} spilled", run.spilled());
    assert_eq!(state.arms()[0].limit_violations, 0);
    assert!(run.clearance > 0.0, "{}", run.clearance);
    let said = |what: &str| run.lines.iter().any(|line| line.contains(what));
    assert!(said("[break]") && said("limit, by"), "{:#?}", run.lines);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_task_that_is_killed_every_half_second_still_fills_and_finds_the_bin() {
    let mut run = Run::new(&spec(4, ""));
    run.restarts = true;
    let run = run.finish();
    assert_eq!(run.outcome(), Some(Outcome::Done), "{:#?}", run.lines);
    let decision = run.sim.decision();
    assert_eq!((decision.drops, decision.recoveries), (1, 0));
    assert!(run.sim.task_restarts() > 40);
    assert_eq!(run.sim.state().arms()[0].limit_violations, 0);
}

#[test]
fn a_bin_that_is_pulled_out_of_reach_ends_the_job_with_that_reason() {
    let pull =
        r#"{"at_s": 0.1, "do": "drag", "object": "bin", "to": [1.3, 0.6, -0.45], "for_s": 6.0}"#;
    let run = Run::new(&spec(2, pull)).finish();
    assert_eq!(run.outcome(), Some(Outcome::Failed), "{:#?}", run.lines);
    let reason = run.sim.decision().reason;
    assert_eq!(reason.as_str(), "bin_out_of_reach");
}

/// A corner of three plates in which the bin rests on its own corner, each of its sides steeper
/// than suction could take.
fn on_its_corner(cell: &mut Cell) {
    let diagonal = Vector3::new(1.0, 1.0, 1.0);
    let turn = UnitQuaternion::rotation_between(&diagonal, &Vector3::z()).unwrap();
    let pose = Isometry3::from_parts(Translation3::new(0.3, 0.7, -0.25), turn);
    cell.objects[BIN].pose = pose;
    let size = Vector3::new(0.30, 0.20, 0.135);
    for axis in 0..3 {
        let mut plate = cell.fixtures[0].clone();
        let mut size_m: [f64; 3] = size.into();
        size_m[axis] = PLATE_M;
        let mut away = Vector3::zeros();
        away[axis] = -0.5 * (size[axis] + PLATE_M) - 1.0e-4;
        plate.name = format!("plate_{axis}");
        plate.shape = Shape::Box { size_m };
        plate.pose = pose * Translation3::from(away);
        plate.obstacle = false;
        cell.fixtures.push(plate);
    }
}

#[test]
fn a_bin_that_lies_at_an_angle_ends_the_job_with_that_reason() {
    let spec = spec(2, "");
    let mut cell = spec.load_cell_from(&cell_model::Data::checkout()).unwrap();
    on_its_corner(&mut cell);
    let run = Run::of(&spec, cell).finish();
    assert_eq!(run.outcome(), Some(Outcome::Failed), "{:#?}", run.lines);
    let reason = run.sim.decision().reason;
    assert_eq!(reason.as_str(), "bin_cannot_be_gripped");
    let arm = &run.sim.state().arms()[0];
    assert_eq!((arm.limit_violations, arm.gripper.suction), (0, 0));
}

#[test]
fn a_reset_ends_paused_and_lets_go() {
    let reset = r#"{"at_phase": "HOLDING", "after_s": 3.0, "do": "task_reset"}"#;
    let mut run = Run::new(&spec(3, reset));
    while run.tick() && run.outcome() != Some(Outcome::Paused) {}
    (0..100).for_each(|_| {
        run.tick();
    });
    let state = run.sim.state();
    assert_eq!(run.outcome(), Some(Outcome::Paused), "{:#?}", run.lines);
    assert_eq!((state.panel.task_paused, state.panel.task_started), (1, 0));
}
