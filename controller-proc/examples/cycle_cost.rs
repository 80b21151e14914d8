//! Cost of one cycle of a controller, alone in its cell and beside another arm:
//! everything from a state to a command. Both cells in turns in one run.
//!
//! `cargo run --release -p controller-proc --example cycle_cost`
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "an example that measures"
)]

use cell_model::bench_report::Samples;
use cell_model::{Cell, Data};
use cell_rt::monotonic_ns;
use controller_proc::cycle::Cycle;
use ipc_types::decision::GoalKind;
use ipc_types::{ArmCommand, ArmStatus, Decision, Header, Pose, Wire, WorldState};

const ROUNDS: u64 = 40;
const TICKS: u64 = 1_000;

struct Bench {
    cycle: Cycle,
    state: Box<WorldState>,
    decision: Decision,
    command: ArmCommand,
    status: ArmStatus,
    samples: Samples,
}

impl Bench {
    fn new(demo: &str) -> Self {
        let cell = Cell::load(&Data::embedded(), demo, 1, None).expect("a cell");
        let mut state = Box::new(WorldState::zeroed());
        state.header.generation = 1;
        for (arm, spec) in state.arms.iter_mut().zip(&cell.arms) {
            state.arm_count += 1;
            arm.joint_count = 7;
            arm.tcp = Pose::IDENTITY;
            arm.joint_positions[..7].copy_from_slice(&spec.home);
            arm.setpoint_positions[..7].copy_from_slice(&spec.home);
        }
        let mut decision = Decision::zeroed();
        decision.arm_count = state.arm_count;
        decision.goals[0].kind = GoalKind::Pose.code();
        Self {
            cycle: Cycle::new(&cell, 0).expect("a controller"),
            state,
            decision,
            command: ArmCommand::zeroed(),
            status: ArmStatus::zeroed(),
            samples: Samples::default(),
        }
    }

    /// One way between two places; the other arm, if any, swings its base.
    fn travel(&mut self, round: u64) {
        let side = if round.is_multiple_of(2) { 0.2 } else { -0.2 };
        self.decision.goals[0].target = Pose {
            position: [0.46, -0.2 + side, 0.3],
            orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
        };
        for tick in 0..TICKS {
            self.state.header.tick += 1;
            self.decision.header = Header::caused_by::<Decision>(self.state.header.tick);
            self.state.arms[1].joint_positions[0] = 1.0e-4 * tick as f64;
            let began_ns = monotonic_ns();
            self.cycle.update(
                &self.state,
                Some(&self.decision),
                30,
                &mut self.command,
                &mut self.status,
            );
            self.samples.record(monotonic_ns().saturating_sub(began_ns));
            let arm = &mut self.state.arms[0];
            arm.joint_positions = self.command.joint_positions;
        }
    }
}

fn main() {
    let demos = ["franka-stack", "franka-pyramid"];
    let mut benches = demos.map(Bench::new);
    for round in 0..ROUNDS {
        for bench in &mut benches {
            bench.travel(round);
        }
    }
    for (demo, bench) in demos.into_iter().zip(benches) {
        let row = bench.samples.into_row(demo.to_owned());
        println!(
            "{demo}: p50 {:.1} {unit}, p99 {:.1} {unit}",
            row.p50,
            row.p99,
            unit = row.unit
        );
    }
}
