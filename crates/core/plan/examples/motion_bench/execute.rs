//! Motion at 1 kHz: motion policies alone, or led along a path.

use nalgebra::Isometry3;
use std::sync::Arc;

use plan::{Ahead, Guide, Path, Scene, Settings, led};
use rmp::{MotionState, Obstacle, RmpFlow, TargetId};

use crate::{Arm, Failure};

/// Length of a cycle (s).
const CYCLE_S: f64 = 1.0e-3;
/// Longest motion (ticks).
const TICKS: usize = 20_000;
/// A goal is reached when the tool is within so much of its pose (m, rad).
const NEAR_M: f64 = 0.01;
const NEAR_RAD: f64 = 0.1;
/// How often the clearance is computed (ticks).
const LOOK_TICKS: usize = 10;

/// The result of a motion.
pub(crate) struct Motion {
    pub(crate) reached: bool,
    pub(crate) seconds: f64,
    /// Least distance of a sphere from an obstacle (m).
    pub(crate) clearance: f64,
}

/// Moves the arm of `flow` from `start` to `goal` among `obstacles`, along `path` if there is
/// one.
pub(crate) fn execute(
    arm: &Arm<'_>,
    start: &[f64],
    goal: &[f64],
    obstacles: &[Obstacle],
    path: Option<&Path>,
) -> Result<Motion, Failure> {
    let mut flow = arm.flow(obstacles)?;
    let tool = flow.add_target_frame(arm.robot.tcp_frame_name())?;
    let target = pose(&mut flow, tool, goal)?;
    let limits = arm.robot.limits();
    let mut state = MotionState::at_rest(start);
    let scene = Scene::new(obstacles)?;
    let mut guide = path.map(|path| {
        let body = Arc::clone(&arm.body);
        Guide::new(body, scene, path, &Settings::default(), Ahead::default())
    });
    if guide.is_some() {
        let (posture, collision) = led(&arm.robot.rmpflow);
        flow.set_gains(posture, collision)?;
    }
    let mut motion = Motion {
        reached: false,
        seconds: 0.0,
        clearance: f64::INFINITY,
    };
    for tick in 0..TICKS {
        let now = pose(&mut flow, tool, &state.positions)?;
        let off = (now.translation.vector - target.translation.vector).norm();
        if off < NEAR_M && now.rotation.angle_to(&target.rotation) < NEAR_RAD {
            motion.reached = true;
            motion.seconds = tick as f64 * CYCLE_S;
            break;
        }
        let next = match &mut guide {
            Some(guide) => {
                let led = guide.lead(&state.positions).to_vec();
                flow.set_posture(&led)?;
                pose(&mut flow, tool, &led)?
            }
            None => target,
        };
        flow.set_position_target(tool, Some(next.translation.vector))?;
        flow.set_orientation_target(tool, Some(next.rotation))?;
        flow.step_cell(&mut state, &limits, CYCLE_S)?;
        if tick % LOOK_TICKS == 0 {
            let clearance = arm.distance(&state.positions, obstacles);
            motion.clearance = motion.clearance.min(clearance);
        }
    }
    Ok(motion)
}

fn pose(flow: &mut RmpFlow, tool: TargetId, at: &[f64]) -> Result<Isometry3<f64>, Failure> {
    let pose = flow.target_frame_pose_at(tool, at)?;
    pose.ok_or_else(|| "the tool is no frame".into())
}
