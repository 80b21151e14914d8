//! Cost of one cycle of a controller: a Panda alone in its cell and beside another arm, a UR10
//! among 40 obstacles, four fixtures and a stack of 36 bins, without and with a bin in its
//! gripper. Everything from a state to a command; all in turns in one run.
//!
//! `cargo run --release -p robocell-benches --features measure --example cycle_cost`
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "an example that measures"
)]

use std::fmt::Write;

#[allow(dead_code, reason = "it prints by itself")]
#[path = "../src/report.rs"]
mod report;

use cell_model::{Cell, Data};
use cell_rt::monotonic_ns;
use controller_proc::cycle::Cycle;
use ipc_types::decision::GoalKind;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmCommand, ArmStatus, Decision, Header, Pose, Wire, WorldState};
use report::Samples;

const ROUNDS: u64 = 40;
const TICKS: u64 = 1_000;

struct Bench {
    cycle: Cycle,
    /// Middle of the motion.
    from: Pose,
    state: Box<WorldState>,
    decision: Decision,
    command: ArmCommand,
    status: ArmStatus,
    samples: Samples,
}

impl Bench {
    fn new(cell: &Cell, from: Pose, held: bool) -> Self {
        let mut state = Box::new(WorldState::zeroed());
        state.header.generation = 1;
        for (arm, spec) in state.arms.iter_mut().zip(&cell.arms) {
            let joints = spec.home.len();
            state.arm_count += 1;
            arm.joint_count = u32::try_from(joints).expect("few joints");
            arm.tcp = Pose::IDENTITY;
            arm.joint_positions[..joints].copy_from_slice(&spec.home);
            arm.setpoint_positions[..joints].copy_from_slice(&spec.home);
        }
        state.object_count = u32::try_from(cell.objects.len()).expect("few objects");
        for (slot, object) in state.objects.iter_mut().zip(&cell.objects) {
            slot.flags = OBJECT_ENABLED;
            slot.pose = Pose::IDENTITY;
            slot.pose.position = object.pose.translation.vector.into();
        }
        if held {
            state.arms[0].gripper.attached = 1;
            state.arms[0].gripper.held_object = 1;
        }
        let mut decision = Decision::zeroed();
        decision.arm_count = state.arm_count;
        decision.goals[0].kind = GoalKind::Pose.code();
        decision.goals[0].object_mask = u64::MAX;
        decision.goals[0].obstacle_mask = u64::MAX;
        Self {
            cycle: Cycle::new(cell, 0).expect("a controller"),
            from,
            state,
            decision,
            command: ArmCommand::zeroed(),
            status: ArmStatus::zeroed(),
            samples: Samples::default(),
        }
    }

    /// One motion between two positions; the other arm, if any, swings its base.
    fn travel(&mut self, round: u64) {
        let side = if round.is_multiple_of(2) { 0.2 } else { -0.2 };
        self.decision.goals[0].target = self.from;
        self.decision.goals[0].target.position[1] += side;
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
            // The arm follows its command exactly: no physics is measured.
            let arm = &mut self.state.arms[0];
            arm.joint_positions = self.command.joint_positions;
        }
    }
}

/// A UR10 cell in the state before the last bin.
fn ur10_cell() -> Cell {
    let mut text = String::from(UR10);
    for index in 0..4 {
        let x = 0.3 * f64::from(index);
        let _written = write!(
            text,
            "[[fixture]]\nname = \"wall_{index}\"\nshape = {{ kind = \"box\", \
             size_m = [0.2, 0.2, 0.5] }}\nposition_m = [{x}, 1.3, -0.3]\nfriction = 0.5\n\
             obstacle = true\ncolour = [0.5, 0.5, 0.5]\n"
        );
    }
    for column in 0..9 {
        let (x, y) = (0.21 * f64::from(column % 3), 0.31 * f64::from(column / 3));
        let _written = write!(
            text,
            "[[object]]\nname = \"bin_{column}\"\ncount = 4\nshape = {{ kind = \"bin\", \
             size_m = [0.2, 0.3, 0.147], wall_m = 0.005 }}\nmass_kg = 0.6\nfriction = 0.6\n\
             position_m = [{}, {}, -0.5]\npitch_m = [0.0, 0.0, 0.135]\nobstacle = true\n\
             colour = [0.3, 0.5, 0.8]\n",
            0.63 + x,
            y - 0.62
        );
    }
    Cell::from_text(&Data::checkout(), "ur10", "ur10.toml", &text, 1, None).expect("a cell")
}

const UR10: &str = r#"
description = "a UR10 and its stack"
policies = ["follow"]
default_policy = "follow"
time_limit_s = 100.0
task = { kind = "reach" }
camera = { eye_m = [2.0, 2.0, 1.0], target_m = [0.0, 0.0, 0.0] }
[[arm]]
name = "arm"
robot = "ur10"
base_position_m = [0.0, 0.0, 0.0]
"#;

fn main() {
    let demo =
        |name: &str| Cell::load(&Data::checkout(), name, 1, None).expect("a cell of this program");
    let pose = |position, orientation_wxyz| Pose {
        position,
        orientation_wxyz,
    };
    let panda = pose([0.46, -0.2, 0.3], [0.0, 1.0, 0.0, 0.0]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let ur10 = pose([0.5, 0.3, 0.3], [half, 0.0, half, 0.0]);
    let mut benches = [
        ("panda alone", demo("franka-stack"), panda, false),
        ("panda beside another", demo("franka-pyramid"), panda, false),
        ("ur10, 40 obstacles", ur10_cell(), ur10, false),
        ("ur10, 39 obstacles, bin held", ur10_cell(), ur10, true),
    ]
    .map(|(name, cell, from, held)| (name, Bench::new(&cell, from, held)));
    for round in 0..ROUNDS {
        for (_, bench) in &mut benches {
            bench.travel(round);
        }
    }
    for (name, bench) in benches {
        let row = bench.samples.into_row(name.to_owned());
        println!(
            "{name}: p50 {:.1} {unit}, p99 {:.1} {unit}",
            row.p50,
            row.p99,
            unit = row.unit
        );
    }
}
