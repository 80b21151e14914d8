//! The tool goes around a circle, twice: a whole task program.

use std::f64::consts::TAU;
use std::process::ExitCode;

use robocell_task::{ArmIntent, Job, Observation, Outcome, Output, Policies, Policy, Pose};

struct Circle;

impl Policy for Circle {
    /// Where the tool shall be follows from the time: nothing to remember.
    type Memory = ();

    fn decide(&self, (): &mut (), cell: &Observation<'_>, _: &mut Job, out: &mut Output) {
        let turns = cell.time().seconds() / 4.0;
        let (sin, cos) = (turns * TAU).sin_cos();
        let target = Pose {
            position: [0.5, 0.15 * cos, 0.4 + 0.15 * sin],
            orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
        };
        // The same key at every tick: one goal whose target moves.
        out.arm(0, ArmIntent::pose(1, target));
        if turns >= 2.0 {
            out.outcome = Outcome::Done;
        }
    }
}

fn main() -> ExitCode {
    robocell_task_program::main(Policies::new().policy("circle", |_| Circle))
}
