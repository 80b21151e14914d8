//! Costs of control and physics, each in one run.

use std::hint::black_box;
use std::io::stdout;

use crate::report::{Report, Row, Samples};
use cell_model::random::Random;
use cell_model::{Data, Robot};
use cell_rt::monotonic_ns;
use cell_rt::priority::{self, CONTROLLER_PRIORITY};
use ipc_types::TICK_S;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rmp::{JointLimits, MotionState, Obstacle, RmpFlow, TargetId};

use crate::error::CoreError;
use crate::python::PythonStepper;
use crate::reference::{self, Kernel};
use crate::{mujoco, panda, piles, pinch};
use cell_sim::OneProcess;
use cell_sim::eval::template;

/// Obstacles of the control bench.
const OBSTACLES: [usize; 4] = [0, 10, 20, 50];
/// Rounds through all rows, so that a slow minute affects all of them.
const ROUNDS: usize = 20;
/// States per round, chosen at random.
const STATES: usize = 500;
/// Demo of the physics bench.
const DEMO: &str = "franka-stack";
/// Turns of each engine that is stepped from Python, and steps per turn.
const PYTHON_TURNS: usize = 40;
const PYTHON_STEPS: usize = 100;
const CELL_PROGRAM: &str = include_str!("cell.py");
/// Ticks of each other demo.
const OTHER_TICKS: u64 = 15_000;

/// The part to be measured.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Core {
    /// The RMPflow cycle.
    Control,
    /// The step of physics, and the whole tick.
    Physics,
}

/// Measures `core` and prints.
pub(crate) fn run(core: Core, json: bool) -> Result<(), CoreError> {
    let report = match core {
        Core::Control => control()?,
        Core::Physics => physics()?,
    };
    report
        .write(&mut stdout().lock(), json)
        .map_err(CoreError::Output)
}

/// The RMPflow cycle of the Panda with all its spheres among random obstacles:
/// evaluate, resolve within limits, integrate; without self-collision and with it; and a
/// fixed kernel, which they are compared with.
// The core and class of a controller, as its cycle is compared with a tick.
fn control() -> Result<Report, CoreError> {
    let granted = priority::request(CONTROLLER_PRIORITY, Some(0));
    let mut report = Report::new("control", granted.fifo, &granted.refused);
    // The same robot twice, so that the rows differ by self-collision alone.
    let with = Robot::load(&Data::checkout(), "panda")?;
    let without = Robot {
        self_spheres: Vec::new(),
        ..with.clone()
    };
    let spheres = with.spheres.len();
    let mut rows = Vec::new();
    for (robot, what) in [(&without, ""), (&with, ", self-collision")] {
        for count in OBSTACLES {
            let name = format!("{spheres} spheres x {count} obstacles{what}");
            let samples = Samples::with_capacity(ROUNDS * STATES);
            rows.push((flow(robot, count)?, samples, name));
        }
    }
    // A fixed seed: two runs measure the same states.
    let limits = with.limits();
    let mut random = Random::new(7);
    let kernel = Kernel::new();
    let mut fixed = Samples::with_capacity(ROUNDS * STATES);
    // All rows in each round: a ratio is of the same minutes, not of a quiet and a busy one.
    for _ in 0..ROUNDS {
        for _ in 0..STATES {
            let began_ns = monotonic_ns();
            kernel.work();
            fixed.record(monotonic_ns().saturating_sub(began_ns));
        }
        let states: Vec<MotionState> = (0..STATES).map(|_| state(&limits, &mut random)).collect();
        for ((flow, _), samples, _) in &mut rows {
            for state in &states {
                // A copy, as the step changes it: every row starts from the same states.
                let mut state = state.clone();
                let began_ns = monotonic_ns();
                // The result is used, or the compiler could leave the work out.
                let stepped = flow.step_cell(&mut state, &limits, TICK_S);
                samples.record(monotonic_ns().saturating_sub(began_ns));
                black_box((stepped.is_ok(), state));
            }
        }
    }
    let names: Vec<String> = rows.iter().map(|(.., name)| name.clone()).collect();
    let rows = rows.into_iter();
    report.rows = rows
        .map(|(_, samples, name)| samples.into_row(name))
        .collect();
    report.rows.push(fixed.into_row(reference::NAME.to_owned()));
    report.notes.push(reference::NOTE.to_owned());
    for name in names {
        report.compare(&name, reference::NAME);
    }
    Ok(report)
}

fn flow(robot: &Robot, obstacles: usize) -> Result<(RmpFlow, TargetId), CoreError> {
    let mut flow = robot.motion_policies(obstacles)?;
    let tool = flow.add_target_frame(robot.tcp_frame_name())?;
    flow.set_position_target(tool, Some(Vector3::new(0.5, 0.1, 0.4)))?;
    flow.set_orientation_target(tool, Some(UnitQuaternion::from_euler_angles(3.1, 0.1, 0.0)))?;
    let mut random = Random::new(42);
    for index in 0..obstacles {
        // An obstacle that is refused would make the bench faster than the real cycle.
        flow.obstacles_mut()
            .add(random_obstacle(index, &mut random))?;
    }
    Ok((flow, tool))
}

/// A position in the workspace; every third obstacle is a sphere.
fn random_obstacle(index: usize, random: &mut Random) -> Obstacle {
    let mut within =
        |low: f64, high: f64| 0.5 * (low + high) + random.around_zero(0.5 * (high - low));
    let center = Vector3::new(within(0.3, 0.85), within(-0.6, 0.6), within(0.0, 0.9));
    let size = Vector3::new(within(0.02, 0.08), within(0.02, 0.08), within(0.02, 0.08));
    if index % 3 == 2 {
        return Obstacle::sphere(center, size.x);
    }
    let turn =
        UnitQuaternion::from_euler_angles(within(-3.0, 3.0), within(-1.5, 1.5), within(-3.0, 3.0));
    Obstacle::cuboid(
        Isometry3::from_parts(Translation3::from(center), turn),
        2.0 * size,
    )
}

fn state(limits: &JointLimits, random: &mut Random) -> MotionState {
    let positions: Vec<f64> = limits
        .lower
        .iter()
        .zip(&limits.upper)
        .map(|(low, high)| 0.5 * (low + high) + random.around_zero(0.45 * (high - low)))
        .collect();
    let mut state = MotionState::at_rest(&positions);
    state
        .velocities
        .iter_mut()
        .for_each(|v| *v = random.around_zero(0.5));
    state
}

/// A whole job in one process: the engine's step alone, and the whole tick; then the other
/// demos, and heaps.
fn physics() -> Result<Report, CoreError> {
    let granted = priority::request(CONTROLLER_PRIORITY, Some(0));
    let mut report = Report::new("physics", granted.fifo, &granted.refused);
    let (step, tick) = job(DEMO, u64::MAX)?;
    let factor = real_time(DEMO, &tick);
    report.rows.extend([step, tick, factor]);
    report.compare("tick in one process", "physics step");
    for (demo, _) in Data::checkout().demos() {
        if demo == DEMO {
            continue;
        }
        // A demo that does not run here must not end the bench; the report names it.
        let (step, mut tick) = match job(&demo, OTHER_TICKS) {
            Ok(rows) => rows,
            Err(error) => {
                report.notes.push(format!("{demo} does not run: {error}"));
                continue;
            }
        };
        let factor = real_time(&demo, &tick);
        tick.name = format!("{demo}, tick");
        let name = format!("{demo}, physics step");
        report.rows.extend([Row { name, ..step }, tick, factor]);
    }
    panda::run(&mut report)?;
    pinch::run(&mut report)?;
    piles::run(&mut report)?;
    in_python(&mut report)?;
    Ok(report)
}

/// A step of a cell from Python, with physics, controllers and recorder's state, compared with
/// `MuJoCo`'s step of the same arm and objects with its position servos.
fn in_python(report: &mut Report) -> Result<(), CoreError> {
    // Skipped with a note: most machines have no Python package.
    let Some(mut ours) = PythonStepper::start(CELL_PROGRAM, DEMO) else {
        let note = "the Python interpreter has no package robocell: no steps from Python";
        report.notes.push(note.to_owned());
        return Ok(());
    };
    let cell = template(DEMO, "").load_cell_from(&Data::checkout())?;
    let mut other = mujoco::start(&cell, panda::SETTINGS);
    let (mut own_times, mut times) = (Samples::default(), Samples::default());
    // Turns of both engines, as for all ratios.
    for _ in 0..PYTHON_TURNS {
        own_times.record_all(&ours.step(PYTHON_STEPS, &[]));
        if let Some(mujoco) = &mut other {
            times.record_all(&mujoco.step(PYTHON_STEPS, &[]));
        }
    }
    let name = format!("{DEMO} in Python, Cell.step()");
    report.rows.push(own_times.into_row(name.clone()));
    if let Some(mujoco) = other {
        let against = format!("{DEMO} in Python, mj_step of MuJoCo {}", mujoco.version());
        report.rows.push(times.into_row(against.clone()));
        report.compare(&name, &against);
    }
    Ok(())
}

/// Simulated over real time of `demo`: of its median, and of its slow ticks.
fn real_time(demo: &str, tick: &Row) -> Row {
    let of = |tick_us: f64| 1.0e3 / tick_us.max(1.0e-3);
    let figures = [tick.p50, tick.p99, tick.p999, tick.max].map(of);
    Row::new(format!("{demo}, speed of the tick"), tick.n, figures).in_unit("x real time")
}

/// Runs a demo to its end, or up to the tick `most`; returns the costs of the engine's step and
/// of the whole tick.
fn job(demo: &str, most: u64) -> Result<(Row, Row), CoreError> {
    let mut spec = template(demo, "");
    let cell = spec.load_cell_from(&Data::checkout())?;
    spec.policy.clone_from(&cell.default_policy);
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell)?;
    let (mut steps, mut ticks) = (Samples::default(), Samples::default());
    while sim.state().header.tick < most {
        let (began_ns, mut stepped_ns) = (monotonic_ns(), (0, 0));
        // The engine's step is observed inside of the tick, so
        // both figures are of the same ticks.
        let going = sim.tick_observed(|before| {
            if before {
                stepped_ns.0 = monotonic_ns();
            } else {
                stepped_ns.1 = monotonic_ns();
            }
        })?;
        if !going {
            break;
        }
        steps.record(stepped_ns.1.saturating_sub(stepped_ns.0));
        ticks.record(monotonic_ns().saturating_sub(began_ns));
    }
    let step: Row = steps.into_row("physics step".to_owned());
    let tick: Row = ticks.into_row("tick in one process".to_owned());
    Ok((step, tick))
}
