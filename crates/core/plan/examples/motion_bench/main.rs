//! Plans the problems of `MotionBenchMaker`:
//!
//! `cargo run --release -p robocell-plan --features measure --example motion_bench -- PROBLEMS.json [--robot NAME|CONFIG]
//! [--reactive|--plan|--execute]`
//!
//! PROBLEMS.json is what the script `problem_tar_to_pkl_json.py` of the source package of
//! `vamp-planner` makes of its problems. The robot is one of `robots/` (default: `panda`), or
//! files as `robocell run --robot` takes them. For each scene it prints how many of the
//! problems with a free start and a free goal are solved, the times, lengths of paths, and
//! the least clearance of the spheres from the exact shapes along the paths, each checked at
//! every 0.005 rad in double precision. `--execute` follows each path with motion policies at
//! 1 kHz and `--reactive` moves with motion policies alone: then a problem is solved when the
//! tool is within 1 cm and 0.1 rad of the goal within 20 s, and the times are those of the
//! motion.

mod execute;
mod problems;

use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use cell_model::{Data, Robot, RobotFiles};
use execute::execute;
use nalgebra::Point3;
use plan::{Body, BodySetup, PlanError, Scene, Settings, plan};
use rmp::{Obstacle, RmpFlow};

/// Each finger is that far from the middle (m) in the problems, beyond its limit.
const FINGER_M: f64 = 0.065;

const USAGE: &str =
    "usage: motion_bench PROBLEMS.json [--robot NAME|CONFIG] [--reactive|--plan|--execute]";

/// The measured motion.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Reactive,
    Plan,
    Execute,
}

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(5),
        Err(error) => {
            let _ended = writeln!(io::stderr(), "motion_bench: {error}");
            ExitCode::from(3)
        }
    }
}

struct Row {
    valid: usize,
    solved: usize,
    contacts: usize,
    times_us: Vec<f64>,
    lengths: Vec<f64>,
    least_mm: f64,
}

fn run() -> Result<bool, Failure> {
    let mut arguments = std::env::args().skip(1);
    let (mut file, mut name, mut mode) = (None, "panda".to_owned(), Mode::Plan);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--robot" => name = arguments.next().ok_or(USAGE)?,
            "--plan" => mode = Mode::Plan,
            "--execute" => mode = Mode::Execute,
            "--reactive" => mode = Mode::Reactive,
            _ if file.is_none() && !argument.starts_with('-') => file = Some(argument),
            _ => return Err(USAGE.into()),
        }
    }
    let file = file.ok_or(USAGE)?;
    let problems = problems::read(&file)?;
    let robot = load(&name)?;
    let arm = Arm::new(&robot, &problems.joints)?;
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "{:22} {:>9} {:>9} {:>9} {:>9} {:>8} {:>9} {:>9}",
        "scene", "solved", "p50 us", "p95 us", "max us", "length", "clear mm", "contacts"
    )?;
    let mut all = Row::default();
    for (scene, list) in &problems.problems {
        let mut row = Row::default();
        for problem in list {
            arm.solve(problem, mode, &mut row)?;
        }
        row.print(scene, &mut out)?;
        all.add(row);
    }
    all.print("all", &mut out)?;
    Ok(all.solved * 100 >= all.valid * 99 && all.contacts == 0)
}

fn load(name: &str) -> Result<Robot, Failure> {
    if !name.contains(['/', '.']) {
        return Ok(Robot::load(&Data::checkout(), name)?);
    }
    let files = RobotFiles {
        urdf: PathBuf::from(name),
        ..RobotFiles::default()
    };
    Ok(Robot::from_files(&files.resolved()?)?)
}

/// The robot of the problems: its fingers are as open as they assume.
struct Arm<'a> {
    robot: &'a Robot,
    joints: Vec<usize>,
    positions: Vec<f64>,
    body: Arc<Body>,
}

impl<'a> Arm<'a> {
    fn new(robot: &'a Robot, joint_names: &[String]) -> Result<Self, Failure> {
        let chain = &robot.chain;
        let index = |name: &String| chain.joint_index(name);
        let joints: Option<Vec<usize>> = joint_names.iter().map(index).collect();
        let joints = joints.ok_or("the robot lacks a joint of the problems")?;
        let mut positions = robot.fixed_joint_positions.clone();
        if let Some(gripper) = &robot.gripper {
            for finger in gripper.finger_joints {
                positions[finger] = FINGER_M;
            }
        }
        let names = chain.joints().iter().map(|joint| joint.name.clone());
        let defaults: BTreeMap<String, f64> = names.zip(positions.iter().copied()).collect();
        let body = Body::new(&BodySetup {
            chain,
            joint_names,
            default_positions: &defaults,
            spheres: &robot.spheres,
            self_spheres: &robot.self_spheres,
            self_ignore: &robot.self_ignore,
            tool: robot.tcp_frame_name(),
        });
        Ok(Self {
            robot,
            joints,
            positions,
            body: Arc::new(body?),
        })
    }

    /// Motion policies among `obstacles`.
    fn flow(&self, obstacles: &[Obstacle]) -> Result<RmpFlow, Failure> {
        let mut robot = self.robot.clone();
        robot.fixed_joint_positions.clone_from(&self.positions);
        let mut flow = robot.motion_policies(obstacles.len())?;
        for obstacle in obstacles {
            flow.obstacles_mut().add(obstacle.clone())?;
        }
        Ok(flow)
    }

    fn solve(&self, problem: &problems::Problem, mode: Mode, row: &mut Row) -> Result<(), Failure> {
        let solids = problem.obstacles();
        let scene = Scene::new(&solids)?;
        let goal = problem.goals.first().ok_or("a problem has no goal")?;
        let began = Instant::now();
        let settings = Settings::default();
        let found = plan(&self.body, &scene, &problem.start, goal, &settings);
        let took_us = began.elapsed().as_secs_f64() * 1e6;
        if let Err(PlanError::InCollision { .. } | PlanError::Configuration { .. }) = found {
            return Ok(());
        }
        row.valid += 1;
        if mode == Mode::Plan {
            row.times_us.push(took_us);
            if let Ok(path) = found {
                let clearance = self.clearance(&path.waypoints, &solids);
                row.take(clearance, path.length);
            }
            return Ok(());
        }
        let path = found.ok().filter(|_| mode == Mode::Execute);
        if mode == Mode::Execute && path.is_none() {
            return Ok(());
        }
        let motion = execute(self, &problem.start, goal, &solids, path.as_ref())?;
        row.contacts += usize::from(motion.clearance < 0.0);
        row.least_mm = row.least_mm.min(1e3 * motion.clearance);
        if motion.reached {
            row.solved += 1;
            row.times_us.push(1e6 * motion.seconds);
            row.lengths.push(path.map_or(0.0, |path| path.length));
        }
        Ok(())
    }

    /// Least distance of a sphere from a solid along a path (m).
    fn clearance(&self, path: &[Vec<f64>], solids: &[Obstacle]) -> f64 {
        let mut least = f64::INFINITY;
        for pair in path.windows(2) {
            let joints = pair[0].iter().zip(&pair[1]);
            let far = joints.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let mut part = 0.0;
            let step = 0.005 / far.max(0.005);
            while part <= 1.0 {
                let joints = pair[0].iter().zip(&pair[1]);
                let at: Vec<f64> = joints.map(|(a, b)| a + part * (b - a)).collect();
                least = least.min(self.distance(&at, solids));
                part += step;
            }
        }
        least
    }

    fn distance(&self, at: &[f64], solids: &[Obstacle]) -> f64 {
        let mut all = self.positions.clone();
        for (&joint, position) in self.joints.iter().zip(at) {
            all[joint] = *position;
        }
        let links = self.robot.link_poses(&all);
        let mut least = f64::INFINITY;
        for sphere in &self.robot.spheres {
            let chain = &self.robot.chain;
            let Some(index) = chain.frame_index(&sphere.frame) else {
                continue;
            };
            let frame = &chain.frames()[index];
            let Some(joint) = frame.joint else { continue };
            let center = links[joint + 1] * frame.pose * Point3::from(sphere.center);
            let distances = solids.iter().map(|solid| solid.distance(&center));
            least = distances.fold(least, |least, d| least.min(d - sphere.radius));
        }
        least
    }
}

impl Default for Row {
    fn default() -> Self {
        Self {
            valid: 0,
            solved: 0,
            contacts: 0,
            times_us: Vec::new(),
            lengths: Vec::new(),
            least_mm: f64::INFINITY,
        }
    }
}

impl Row {
    fn take(&mut self, clearance: f64, length: f64) {
        self.contacts += usize::from(clearance < 0.0);
        self.least_mm = self.least_mm.min(1e3 * clearance);
        self.solved += 1;
        self.lengths.push(length);
    }

    fn add(&mut self, other: Self) {
        self.valid += other.valid;
        self.solved += other.solved;
        self.contacts += other.contacts;
        self.times_us.extend(other.times_us);
        self.lengths.extend(other.lengths);
        self.least_mm = self.least_mm.min(other.least_mm);
    }

    fn print(&mut self, name: &str, out: &mut impl io::Write) -> io::Result<()> {
        self.times_us.sort_by(f64::total_cmp);
        self.lengths.sort_by(f64::total_cmp);
        let at = |values: &[f64], part: f64| {
            let last = values.len().saturating_sub(1);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "an index within the list"
            )]
            let index = (part * last as f64).round() as usize;
            values.get(index).copied().unwrap_or(0.0)
        };
        let times = &self.times_us;
        writeln!(
            out,
            "{name:22} {:>9} {:>9.0} {:>9.0} {:>9.0} {:>8.2} {:>9.1} {:>9}",
            format!("{}/{}", self.solved, self.valid),
            at(times, 0.5),
            at(times, 0.95),
            at(times, 1.0),
            at(&self.lengths, 0.5),
            self.least_mm,
            self.contacts
        )
    }
}
