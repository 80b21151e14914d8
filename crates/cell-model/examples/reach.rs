//! Loads robots and counts the random poses that their motion policies reach:
//!
//! `cargo run --release -p robocell-cell-model --example reach -- [--tip LINK] FILE..`
//!
//! A file is a URDF or a `config.json` of Isaac Sim. The poses are those of joint positions
//! within 0.8 rad (m) of the default ones and 0.15 inside of the limits; there are eight for
//! each robot. One is reached when the tool is within 5 mm and 3 degrees of it after 5 s from
//! the default positions. A row is printed for each file; the exit code is 5 when one was
//! refused, or fewer than 95 % of all poses were reached.

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;

use cell_model::random::Random;
use cell_model::{Robot, RobotFiles};
use nalgebra::Isometry3;
use rmp::MotionState;

const POSES: usize = 8;
const TICKS: usize = 5_000;
const SPREAD: f64 = 0.8;
const INSIDE: f64 = 0.15;
const NEAR_M: f64 = 0.005;
const NEAR_RAD: f64 = 0.052;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).peekable();
    let tip = (arguments.next_if_eq("--tip").is_some())
        .then(|| arguments.next())
        .flatten();
    let (mut refused, mut reached, mut asked) = (0, 0, 0);
    let mut out = io::stdout().lock();
    for file in arguments {
        let row = match row(&file, tip.clone()) {
            Ok((row, count)) => {
                reached += count;
                asked += POSES;
                row
            }
            Err(error) => {
                refused += 1;
                format!("refused: {error}")
            }
        };
        let _ended = writeln!(out, "{file}: {row}");
    }
    let _ended = writeln!(
        out,
        "{reached} of {asked} poses reached, {refused} files refused"
    );
    if refused > 0 || reached * 100 < asked * 95 {
        return ExitCode::from(5);
    }
    ExitCode::SUCCESS
}

type Failure = Box<dyn std::error::Error>;

fn row(file: &str, tip: Option<String>) -> Result<(String, usize), Failure> {
    let files = RobotFiles {
        urdf: PathBuf::from(file),
        tip,
        ..RobotFiles::default()
    };
    let robot = Robot::from_files(&files.resolved()?)?;
    let mut random = Random::new(7);
    let mut worst_mm: f64 = 0.0;
    let mut reached = 0;
    for _ in 0..POSES {
        let goal = pose(&robot, &goal_positions(&robot, &mut random));
        let (off_m, off_rad) = follow(&robot, &goal)?;
        worst_mm = worst_mm.max(1000.0 * off_m);
        if off_m < NEAR_M && off_rad < NEAR_RAD {
            reached += 1;
        }
    }
    let row = format!(
        "{} joints, {} spheres, tool {}, {reached} of {POSES} poses, worst {worst_mm:.1} mm, \
         {} warnings",
        robot.arm_joints.len(),
        robot.spheres.len(),
        robot.tcp_frame_name(),
        robot.warnings.len()
    );
    Ok((row, reached))
}

fn goal_positions(robot: &Robot, random: &mut Random) -> Vec<f64> {
    let defaults = robot.default_joint_positions.iter();
    let specs = robot.arm_specs();
    defaults
        .zip(specs)
        .map(|(default, spec)| {
            let middle = 0.5 * (spec.lower + spec.upper);
            let (low, high) = (spec.lower + INSIDE, spec.upper - INSIDE);
            let wanted = default + random.around_zero(SPREAD);
            if low < high {
                wanted.clamp(low, high)
            } else {
                middle
            }
        })
        .collect()
}

/// Of the tool in the base frame, the other joints where motion policies take them to be.
fn pose(robot: &Robot, positions: &[f64]) -> Isometry3<f64> {
    let mut all = robot.fixed_joint_positions.clone();
    for (&joint, position) in robot.arm_joints.iter().zip(positions) {
        all[joint] = *position;
    }
    robot.frame_pose(robot.tcp_frame, &all).unwrap_or_default()
}

/// Distance (m) and angle (rad) that are left.
fn follow(robot: &Robot, goal: &Isometry3<f64>) -> Result<(f64, f64), Failure> {
    let mut flow = robot.motion_policies(0)?;
    let tool = flow.add_target_frame(robot.tcp_frame_name())?;
    flow.set_position_target(tool, Some(goal.translation.vector))?;
    flow.set_orientation_target(tool, Some(goal.rotation))?;
    let limits = robot.limits();
    let mut state = MotionState::at_rest(&robot.default_joint_positions);
    for _ in 0..TICKS {
        flow.step_cell(&mut state, &limits, 1.0e-3)?;
    }
    let end = pose(robot, &state.positions);
    let off = (end.translation.vector - goal.translation.vector).norm();
    Ok((off, end.rotation.angle_to(&goal.rotation)))
}
