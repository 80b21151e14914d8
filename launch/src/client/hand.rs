//! An arm led by hand from the command line.

use std::time::{Duration, Instant};

use ipc_types::operator::OperatorAction;
use ipc_types::topic::TopicId;
use ipc_types::{GripperGoal, Pose, WorldState};

use super::Session;
use super::operate::{PATIENCE, request, send};
use crate::cli::{GripperArgs, GripperVerb, TargetArgs};
use crate::failure::{Context, Failure};

/// The policy that goes where the operator points, paused or not.
const FOLLOWS: &str = "follow";

/// `robocell gripper open|close`.
pub(crate) fn gripper(args: &GripperArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::Gripper);
    wish.arm = args.arm;
    wish.count = match args.verb {
        GripperVerb::Open => GripperGoal::Open.code(),
        GripperVerb::Close => GripperGoal::Close.code(),
    };
    let session = Session::of(&args.cell.cell)?;
    must_lead(&session)?;
    send(&session, wish)
}

/// `robocell target X Y Z [R P Y]`.
pub(crate) fn target(args: &TargetArgs) -> Result<(), Failure> {
    let (position, angles) = match *args.values.as_slice() {
        [x, y, z] => ([x, y, z], None),
        [x, y, z, roll, pitch, yaw] => ([x, y, z], Some([roll, pitch, yaw])),
        _ => {
            return Err(Failure::usage(
                "a target has three values, or six with roll, pitch and yaw",
            ));
        }
    };
    let session = Session::of(&args.cell.cell)?;
    let state = must_lead(&session)?;
    let orientation_wxyz = match angles {
        None => present_orientation(&state, args.arm)?,
        Some([roll, pitch, yaw]) => quaternion(roll, pitch, yaw),
    };
    let mut wish = request(OperatorAction::Target);
    wish.arm = args.arm;
    wish.pose = Pose {
        position,
        orientation_wxyz,
    };
    send(&session, wish)
}

/// The newest state, unless the task leads the arm: it would not hear a hand.
fn must_lead(session: &Session) -> Result<WorldState, Failure> {
    let state = newest_state(session)?;
    if state.panel.task_paused == 0 && session.spec.policy != FOLLOWS {
        return Err(Failure::configuration(
            "refused: the task leads the arm; `robocell task pause` gives it to you",
        ));
    }
    Ok(state)
}

fn newest_state(session: &Session) -> Result<WorldState, Failure> {
    let bus = session.join()?;
    let mut latest = bus
        .latest::<WorldState>(TopicId::WorldState)
        .cannot("read the world")?;
    let until = Instant::now() + PATIENCE;
    while !latest.refresh() && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(1));
    }
    let silent = "physics publishes no state; `robocell status` says more";
    let state = latest.get().copied();
    state.ok_or_else(|| Failure::configuration(silent))
}

/// The orientation the operator gave last, or the one the tool has.
fn present_orientation(state: &WorldState, arm: u32) -> Result<[f64; 4], Failure> {
    let panel = &state.panel;
    if panel.target_seq > 0 && panel.target_arm == arm {
        return Ok(panel.target.orientation_wxyz);
    }
    let found = state.arms().get(arm as usize);
    found
        .map(|arm| arm.tcp.orientation_wxyz)
        .ok_or_else(|| Failure::configuration(format!("this cell has no arm {arm}")))
}

/// Rotation about the fixed axes x, y, z in this order, as w x y z.
fn quaternion(roll: f64, pitch: f64, yaw: f64) -> [f64; 4] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (
        (roll / 2.0).sin_cos(),
        (pitch / 2.0).sin_cos(),
        (yaw / 2.0).sin_cos(),
    );
    [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
}

#[cfg(test)]
mod tests {
    use super::quaternion;

    #[test]
    fn roll_by_half_a_turn_points_the_tool_down() {
        let [w, x, y, z] = quaternion(std::f64::consts::PI, 0.0, 0.0);
        assert!(w.abs() < 1e-12 && (x - 1.0).abs() < 1e-12 && y.abs() < 1e-12 && z.abs() < 1e-12);
    }

    #[test]
    fn yaw_turns_about_the_vertical_axis_last() {
        let q = quaternion(0.3, -0.2, 0.9);
        assert!((q.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
        let [w, x, y, z] = quaternion(0.0, 0.0, 1.0);
        assert!((w - 0.5_f64.cos()).abs() < 1e-12 && (z - 0.5_f64.sin()).abs() < 1e-12);
        assert!(x.abs() < 1e-12 && y.abs() < 1e-12);
    }
}
