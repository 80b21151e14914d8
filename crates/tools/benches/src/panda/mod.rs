//! The arm of franka-stack with its four cubes: the tick of the demo, the step of physics,
//! and the step of `MuJoCo` for the same scene, in turns.

mod sine;

use cell_model::{ArmSpec, Cell, Data};
use cell_rt::monotonic_ns;
use cell_sim::OneProcess;
use cell_sim::eval::template;
use ipc_types::{ArmCommand, DECISION_TICKS, MAX_ARMS};
use physics_proc::world::{StepInput, World};

use crate::error::CoreError;
use crate::mujoco::{self, Settings};
use crate::python::PythonStepper;
use crate::report::{Report, Samples};
use sine::Sine;

/// The demo of this cell and job.
const DEMO: &str = "franka-stack";
const TICK: &str = "panda and 4 cubes, tick";
const STEP: &str = "panda and 4 cubes, physics step";
const PEER: &str = "panda and 4 cubes, mj_step";
/// Ticks of each row; the job takes longer.
const TICKS: usize = 20_000;
/// Ticks of one row before the turn of the next.
const CHUNK: usize = 100;
/// A sample is the mean of so many ticks in a row, one of which has a decision.
const BLOCK: usize = 10;
const _: () = assert!(BLOCK as u64 == DECISION_TICKS);
/// What `MuJoCo` advises for grasps. Matrices are dense: for a scene this small that is faster.
pub(crate) const SETTINGS: Settings = Settings {
    option: "cone=\"elliptic\" impratio=\"10\" jacobian=\"dense\"",
    geoms: "",
    coupled: true,
};

/// The scene in both engines, and the demo.
struct Bench {
    job: OneProcess,
    sine: Sine,
    world: World,
    peer: Option<PythonStepper>,
    /// Time that the call of the peer adds to its step (ns).
    call_ns: u64,
    tick: Samples,
    step: Samples,
    peer_step: Samples,
}

/// Adds the rows.
pub(crate) fn run(report: &mut Report) -> Result<(), CoreError> {
    Bench::new()?.rows(report, TICKS)
}

impl Bench {
    fn new() -> Result<Self, CoreError> {
        let mut spec = template(DEMO, "");
        let mut cell = spec.load_cell_from(&Data::checkout())?;
        spec.policy.clone_from(&cell.default_policy);
        let job = OneProcess::new(&demos::policies(), &spec, cell.clone())?;
        for arm in &mut cell.arms {
            arm.home = sine::CENTRE.to_vec();
        }
        let mut bench = Self {
            job,
            sine: Sine::new(arm(&cell)?),
            world: World::new(&cell)?,
            peer: mujoco::start(&cell, SETTINGS),
            call_ns: mujoco::time_of_call().unwrap_or_default(),
            tick: Samples::default(),
            step: Samples::default(),
            peer_step: Samples::default(),
        };
        // The start of the motion is not measured.
        for _ in 0..sine::START_TICKS / CHUNK {
            bench.chunk_of_steps();
        }
        (bench.step, bench.peer_step) = Default::default();
        Ok(bench)
    }

    fn rows(mut self, report: &mut Report, ticks: usize) -> Result<(), CoreError> {
        // In turns: a slow minute of the machine affects all rows.
        for _ in 0..ticks / CHUNK {
            self.chunk_of_ticks()?;
            self.chunk_of_steps();
        }
        self.note(report);
        report.rows.push(self.tick.into_row(TICK.to_owned()));
        report.rows.push(self.step.into_row(STEP.to_owned()));
        if self.peer.is_some() {
            report.rows.push(self.peer_step.into_row(PEER.to_owned()));
        }
        report.compare(TICK, PEER);
        report.compare(STEP, PEER);
        Ok(())
    }

    fn chunk_of_ticks(&mut self) -> Result<(), CoreError> {
        for _ in 0..CHUNK / BLOCK {
            let began_ns = monotonic_ns();
            for _ in 0..BLOCK {
                if !self.job.tick()? {
                    return Ok(());
                }
            }
            // The mean of ten ticks, one of which has a decision:
            // single ticks are of two kinds.
            let ns = monotonic_ns().saturating_sub(began_ns);
            self.tick.record(ns / BLOCK as u64);
        }
        Ok(())
    }

    fn chunk_of_steps(&mut self) {
        let commands: Vec<ArmCommand> = (0..CHUNK).map(|_| self.sine.next()).collect();
        let times: Vec<u64> = commands.iter().map(|c| step(&mut self.world, c)).collect();
        record(&times, 0, &mut self.step);
        if let Some(peer) = &mut self.peer {
            let controls = commands.iter().flat_map(|c| self.sine.controls(c));
            let times = peer.step(CHUNK, &controls.collect::<Vec<_>>());
            record(&times, self.call_ns, &mut self.peer_step);
        }
    }

    fn note(&self, report: &mut Report) {
        report.notes.push(format!(
            "panda and 4 cubes: the tick is that of {DEMO} at work, with physics, controller and \
             task; in physics step and mj_step the arm moves free, {} rad at {} Hz at each \
             joint; a sample is the mean of {BLOCK} ticks",
            sine::AMPLITUDE,
            sine::FREQUENCY_HZ
        ));
        let Some(peer) = &self.peer else {
            report.note_once(mujoco::MISSING);
            return;
        };
        let call_us = self.call_ns as f64 / 1.0e3;
        report.notes.push(format!(
            "panda and 4 cubes: MuJoCo {}, 1 ms, Euler, cone elliptic, impratio 10, dense; \
             the call of mj_step from Python, {call_us:.2} us, is subtracted",
            peer.version()
        ));
    }
}

fn arm(cell: &Cell) -> Result<&ArmSpec, CoreError> {
    cell.arms.first().ok_or(CoreError::NoArm(DEMO))
}

/// The time of one step (ns).
fn step(world: &mut World, command: &ArmCommand) -> u64 {
    let mut commands = [None; MAX_ARMS];
    commands[0] = Some(command);
    let decision = None;
    let began_ns = monotonic_ns();
    world.step(&StepInput { commands, decision });
    monotonic_ns().saturating_sub(began_ns)
}

fn record(times_ns: &[u64], call_ns: u64, samples: &mut Samples) {
    for block in times_ns.chunks_exact(BLOCK) {
        let mean_ns = block.iter().sum::<u64>() / BLOCK as u64;
        samples.record(mean_ns.saturating_sub(call_ns));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Wire, WorldState};

    #[test]
    fn the_arm_moves_free_and_where_it_is_led() {
        let mut bench = Bench::new().unwrap();
        for _ in 0..20 {
            bench.chunk_of_steps();
            assert!(bench.world.arm_contacts(0).is_empty());
        }
        let mut state = WorldState::zeroed();
        bench.world.write_state(&mut state);
        let refused = bench.world.refused_commands();
        assert_eq!((state.arms[0].limit_violations, refused), (0, 0));
        let (told, arm) = (bench.sine.next(), state.arms[0]);
        for (told, measured) in told.joint_positions.iter().zip(arm.joint_positions) {
            assert!((told - measured).abs() < 5.0e-3, "{told} {measured}");
        }
    }

    #[test]
    fn the_rows_have_the_names_that_scripts_read() {
        let mut report = Report::new("physics", false, &[]);
        Bench::new().unwrap().rows(&mut report, 2 * CHUNK).unwrap();
        let rows: Vec<_> = report.rows.iter().map(|row| row.name.as_str()).collect();
        // Without MuJoCo the last one is missing.
        let names = [
            "panda and 4 cubes, tick",
            "panda and 4 cubes, physics step",
            "panda and 4 cubes, mj_step",
        ];
        assert!(rows == names || rows == names[..2], "{rows:?}");
        let compared = report.rows.iter().filter(|row| row.ratio.is_some()).count();
        assert_eq!(compared, 2 * (rows.len() - 2));
        assert!(report.rows.iter().all(|row| row.n == 2 * CHUNK / BLOCK));
    }
}
