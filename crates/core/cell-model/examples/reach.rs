//! Loads robots and counts the random poses that their motion policies reach:
//!
//! `cargo run --release -p robocell-cell-model --features measure --example reach -- [--tip LINK] FILE..`
//!
//! A file is a URDF or a `config.json` of Isaac Sim. The poses are those of joint positions
//! within 0.8 rad (m) of the default ones and 0.15, or a tenth of the range, inside of the
//! limits; there are eight for each robot. A pose is reached when the tool is within 5 mm and 3
//! degrees of it 5 s after the start at the default positions. A pose that motion policies miss
//! is tried again along a path that the planner finds, and counted as led. Then the robot
//! follows hostile targets around its base for 1.5 s each: those of
//! `crates/core/rmp/tests/hostile_targets.json`, 72 for each of seven robots, or twelve random poses
//! within 0.4 of the arm's length. The smallest distance of two parts of the robot that may not
//! touch is printed, and the number of cycles that exceeded a limit. A row is printed for each
//! file; the exit code is 5 if one was refused, fewer than 95 % of all poses were reached,
//! parts were nearer than -2 mm, or a limit was exceeded.

use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use cell_model::random::Random;
use cell_model::{Robot, RobotFiles, SelfDistance};
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use plan::{Ahead, Body, BodySetup, Guide, Request, Scene, Settings, Tool, led, plan_to_pose};
use rmp::{JointLimits, MotionState};

/// Length of a cycle (s).
const CYCLE_S: f64 = 1.0e-3;
/// Rounding.
const OVER: f64 = 1.0 + 1.0e-6;
const POSES: usize = 8;
const TICKS: usize = 5_000;
const SPREAD: f64 = 0.8;
const INSIDE: f64 = 0.15;
/// The same as a part of a narrow range.
const INSIDE_PART: f64 = 0.1;
const NEAR_M: f64 = 0.005;
const NEAR_RAD: f64 = 0.052;
const HOSTILE: usize = 12;
const HOSTILE_TICKS: usize = 1_500;
const HOSTILE_REACH: f64 = 0.4;
/// Parts may come this near (m): the spheres are rounder than the robot.
const LEAST_M: f64 = -0.002;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).peekable();
    let tip = (arguments.next_if_eq("--tip").is_some())
        .then(|| arguments.next())
        .flatten();
    let (mut refused, mut reached, mut asked, mut failed) = (0, 0, 0, 0);
    let mut out = io::stdout().lock();
    for file in arguments {
        let row = match row(&file, tip.clone()) {
            Ok(row) => {
                reached += row.reached;
                asked += POSES;
                failed += usize::from(row.nearest < LEAST_M || row.violations > 0);
                row.text
            }
            Err(error) => {
                refused += 1;
                format!("refused: {error}")
            }
        };
        // A reader that closes the pipe changes no result: the exit code is of all files.
        let _ended = writeln!(out, "{file}: {row}");
    }
    let _ended = writeln!(
        out,
        "{reached} of {asked} poses reached, {refused} files refused"
    );
    if refused > 0 || failed > 0 || reached * 100 < asked * 95 {
        return ExitCode::from(5);
    }
    ExitCode::SUCCESS
}

type Failure = Box<dyn std::error::Error>;

/// Result for one robot.
struct Row {
    text: String,
    reached: usize,
    nearest: f64,
    violations: usize,
}

fn row(file: &str, tip: Option<String>) -> Result<Row, Failure> {
    let files = RobotFiles {
        urdf: PathBuf::from(file),
        tip,
        ..RobotFiles::default()
    };
    let robot = Robot::from_files(&files.resolved()?)?;
    // A fixed seed, so that rows of two builds can be compared.
    let mut random = Random::new(7);
    let mut worst_mm: f64 = 0.0;
    let (mut reached, mut planned) = (0, 0);
    for _ in 0..POSES {
        let goal = pose(&robot, &goal_positions(&robot, &mut random));
        let mut off = follow(&robot, &goal)?;
        if !is_near(off) {
            planned += 1;
            off = follow_led(&robot, &goal)?;
        }
        worst_mm = worst_mm.max(1000.0 * off.0);
        reached += usize::from(is_near(off));
    }
    let (nearest, violations) = follow_hostile(&robot)?;
    let text = format!(
        "{} joints, {} spheres, tool {}, {reached} of {POSES} poses ({planned} led), worst {worst_mm:.1} mm, \
         self distance {:.1} mm, {violations} limits exceeded, {} warnings",
        robot.arm_joints.len(),
        robot.spheres.len(),
        robot.tcp_frame_name(),
        1000.0 * nearest,
        robot.warnings.len()
    );
    Ok(Row {
        text,
        reached,
        nearest,
        violations,
    })
}

fn goal_positions(robot: &Robot, random: &mut Random) -> Vec<f64> {
    let defaults = robot.default_joint_positions.iter();
    let specs = robot.arm_specs();
    defaults
        .zip(specs)
        .map(|(default, spec)| {
            let inside = INSIDE.min(INSIDE_PART * (spec.upper - spec.lower));
            let wanted = default + random.around_zero(SPREAD);
            wanted.clamp(spec.lower + inside, spec.upper - inside)
        })
        .collect()
}

/// Of the tool in the base frame, the other joints where motion policies take them to be.
fn pose(robot: &Robot, positions: &[f64]) -> Isometry3<f64> {
    let all = with_arm(robot, positions);
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
        flow.step_cell(&mut state, &limits, CYCLE_S)?;
    }
    let end = pose(robot, &state.positions);
    let off = (end.translation.vector - goal.translation.vector).norm();
    Ok((off, end.rotation.angle_to(&goal.rotation)))
}

fn is_near((off_m, off_rad): (f64, f64)) -> bool {
    off_m < NEAR_M && off_rad < NEAR_RAD
}

/// As [`follow`], along a path that the planner finds.
fn follow_led(robot: &Robot, goal: &Isometry3<f64>) -> Result<(f64, f64), Failure> {
    let mut flow = robot.motion_policies(0)?;
    let tool = flow.add_target_frame(robot.tcp_frame_name())?;
    let (limits, start) = (robot.limits(), &robot.default_joint_positions);
    let (names, settings) = (robot.arm_joint_names(), Settings::default());
    let joints = robot.chain.joints().iter().map(|joint| joint.name.clone());
    let fixed = robot.fixed_joint_positions.iter().copied();
    let body = Body::new(&BodySetup {
        chain: &robot.chain,
        joint_names: &names,
        default_positions: &joints.zip(fixed).collect(),
        spheres: &robot.spheres,
        self_spheres: &robot.self_spheres,
        self_ignore: &robot.self_ignore,
        tool: robot.tcp_frame_name(),
    })?;
    let scene = Scene::default();
    let mut inverse = Tool::new(&mut flow, tool, &limits);
    let request = Request {
        body: &body,
        scene: &scene,
        start,
        posture: start,
        goal,
    };
    let path = plan_to_pose(&request, &mut inverse, &settings)?;
    let (posture, collision) = led(&robot.rmpflow);
    flow.set_gains(posture, collision)?;
    let mut guide = Guide::new(Arc::new(body), scene, &path, &settings, Ahead::default());
    let mut state = MotionState::at_rest(start);
    for _ in 0..TICKS {
        let next = guide.lead(&state.positions).to_vec();
        flow.set_posture(&next)?;
        let target = flow.target_frame_pose_at(tool, &next)?.unwrap_or(*goal);
        flow.set_position_target(tool, Some(target.translation.vector))?;
        flow.set_orientation_target(tool, Some(target.rotation))?;
        flow.step_cell(&mut state, &limits, CYCLE_S)?;
    }
    let end = pose(robot, &state.positions);
    let off = (end.translation.vector - goal.translation.vector).norm();
    Ok((off, end.rotation.angle_to(&goal.rotation)))
}

/// Least distance of two parts that may not touch on the way along the hostile targets (m),
/// and ticks in which a limit was exceeded.
fn follow_hostile(robot: &Robot) -> Result<(f64, usize), Failure> {
    let mut flow = robot.motion_policies(0)?;
    let tool = flow.add_target_frame(robot.tcp_frame_name())?;
    let limits = robot.limits();
    let mut distance = SelfDistance::new(robot);
    let mut state = MotionState::at_rest(&robot.default_joint_positions);
    let (mut nearest, mut violations) = (f64::INFINITY, 0);
    for [x, y, z, qw, qx, qy, qz] in hostile_targets(robot)? {
        let turn = Quaternion::new(qw, qx, qy, qz);
        flow.set_position_target(tool, Some(Vector3::new(x, y, z)))?;
        flow.set_orientation_target(tool, Some(UnitQuaternion::new_normalize(turn)))?;
        for tick in 0..HOSTILE_TICKS {
            let before = state.clone();
            flow.step_cell(&mut state, &limits, CYCLE_S)?;
            violations += usize::from(!is_within(&limits, &before, &state));
            if tick % 10 == 0 {
                let all = with_arm(robot, &state.positions);
                nearest = nearest.min(distance.nearest(robot, &all, f64::INFINITY));
            }
        }
    }
    Ok((nearest, violations))
}

/// The targets in the repository, or, for a robot that is not there, twelve random ones:
/// position (m), then orientation w x y z, in the base frame.
fn hostile_targets(robot: &Robot) -> Result<Vec<[f64; 7]>, Failure> {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../rmp/tests/hostile_targets.json"
    );
    let text = std::fs::read_to_string(file).map_err(|error| format!("{file}: {error}"))?;
    let mut all: BTreeMap<String, Vec<[f64; 7]>> = serde_json::from_str(&text)?;
    if let Some(listed) = all.remove(&robot.name) {
        return Ok(listed);
    }
    let offsets = robot.chain.joints().iter();
    let length: f64 = offsets.map(|j| j.origin.translation.vector.norm()).sum();
    let reach = HOSTILE_REACH * length;
    let mut random = Random::new(12);
    let mut target = || {
        let mut within = |half: f64| random.around_zero(half);
        let height = within(reach) + reach;
        [
            within(reach),
            within(reach),
            height,
            within(1.0),
            within(1.0),
            within(1.0),
            within(1.0),
        ]
    };
    Ok((0..HOSTILE).map(|_| target()).collect())
}

/// Whether one cycle kept every limit.
fn is_within(limits: &JointLimits, before: &MotionState, after: &MotionState) -> bool {
    (0..after.positions.len()).all(|joint| {
        let acceleration = (after.velocities[joint] - before.velocities[joint]) / CYCLE_S;
        let jerk = (acceleration - before.accelerations[joint]) / CYCLE_S;
        let (lower, upper) = (limits.lower[joint], limits.upper[joint]);
        after.velocities[joint].abs() <= limits.velocity[joint] * OVER
            && acceleration.abs() <= limits.acceleration[joint] * OVER
            && jerk.abs() <= limits.jerk[joint] * OVER
            && (lower - 1e-9..=upper + 1e-9).contains(&after.positions[joint])
    })
}

/// All joints of the chain, those of the arm at `arm`.
fn with_arm(robot: &Robot, arm: &[f64]) -> Vec<f64> {
    let mut all = robot.fixed_joint_positions.clone();
    robot.place_arm(arm, &mut all);
    all
}
