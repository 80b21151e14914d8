//! Answers one case from outside: builds a controller from a user's robot files,
//! steps it, and prints acceleration, force, metric and state as JSON, to be
//! compared with any other implementation of the same formulas.
//!
//! `cargo run --release -p robocell-rmp --features measure --example evaluate -- CASE.json`
//!
//! Exit code 0 with one JSON object on stdout, or 2 with one error on stderr.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "the answer goes to stdout"
)]

mod case;

use std::collections::BTreeMap;
use std::process::ExitCode;

use case::{Case, Problem, Resolve};
use rmp::{MotionState, RmpFlow, StepReport};
use serde::Serialize;

#[derive(Serialize)]
struct Answer {
    acceleration: Vec<f64>,
    force: Vec<f64>,
    metric: Vec<Vec<f64>>,
    final_q: Vec<f64>,
    final_qd: Vec<f64>,
    frame_positions: BTreeMap<String, [f64; 3]>,
    /// Least distance of a sphere from an obstacle on the way (m); none without obstacles.
    clearance: Option<f64>,
    /// Least distance of two parts of the robot on the way (m); none if they were never within
    /// 0.25 m, and for `exact`, which does not compute it.
    self_clearance: Option<f64>,
}

impl Answer {
    fn is_finite(&self) -> bool {
        let lists = [
            &self.acceleration,
            &self.force,
            &self.final_q,
            &self.final_qd,
        ];
        let numbers = lists.into_iter().chain(&self.metric).flatten();
        let positions = self.frame_positions.values().flatten();
        numbers.chain(positions).all(|x| x.is_finite())
    }
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (Some(path), None) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: evaluate CASE.json");
        return ExitCode::from(2);
    };
    match answer(&path) {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("evaluate: {error}");
            ExitCode::from(2)
        }
    }
}

fn answer(path: &str) -> Result<String, String> {
    let case = Case::read(path)?;
    let mut problem = case.build(path)?;
    let mut state = problem.state.clone();
    let mut least = Least::default();
    for k in 0..case.steps {
        problem
            .move_target(&case, k)
            .map_err(|e| format!("{path}: {e}"))?;
        let report = step(&mut problem, &case, &mut state);
        least.take(&report.map_err(|e| format!("{path}: step {k}: {e}"))?);
    }
    let answer =
        describe(&mut problem, &case, &state, least).map_err(|e| format!("{path}: {e}"))?;
    if !answer.is_finite() {
        let advice =
            "the numbers of the case are too large for the formulas; check q, qd and the targets";
        return Err(format!("{path}: the answer is not finite: {advice}"));
    }
    serde_json::to_string(&answer).map_err(|e| format!("{path}: the answer is no JSON: {e}"))
}

/// Least distances of a motion (m).
#[derive(Clone, Copy, Default)]
struct Least {
    clearance: Option<f64>,
    self_clearance: Option<f64>,
}

impl Least {
    fn take(&mut self, report: &StepReport) {
        let least = |a: Option<f64>, b: f64| Some(a.map_or(b, |a| a.min(b)));
        if let Some(near) = report.clearance {
            self.clearance = least(self.clearance, near.distance);
        }
        if report.self_clearance.is_finite() {
            self.self_clearance = least(self.self_clearance, report.self_clearance);
        }
    }
}

fn step(
    problem: &mut Problem,
    case: &Case,
    state: &mut MotionState,
) -> Result<StepReport, rmp::FlowError> {
    match case.resolve {
        Resolve::Exact => problem.flow.step_exact(state, case.dt),
        Resolve::Cell => problem.flow.step_cell(state, &problem.limits, case.dt),
    }
}

fn describe(
    problem: &mut Problem,
    case: &Case,
    state: &MotionState,
    mut least: Least,
) -> Result<Answer, rmp::FlowError> {
    // One more step of a copy resolves at this very state.
    let mut next = state.clone();
    least.take(&step(problem, case, &mut next)?);
    let flow: &RmpFlow = &problem.flow;
    let metric = flow
        .root()
        .metric
        .row_iter()
        .map(|row| row.iter().copied().collect());
    let position = |(name, id): (&String, &rmp::TargetId)| {
        let pose = flow.target_frame_pose(*id)?;
        Some((name.clone(), pose.translation.vector.into()))
    };
    Ok(Answer {
        acceleration: next.accelerations,
        force: flow.root().force.iter().copied().collect(),
        metric: metric.collect(),
        final_q: state.positions.clone(),
        final_qd: state.velocities.clone(),
        frame_positions: problem.frames.iter().filter_map(position).collect(),
        clearance: least.clearance,
        self_clearance: least.self_clearance,
    })
}
