//! A row of an answer as the actions of all arms. Pure.

use robocell_task::{ArmIntent, GoalKind, GripperGoal, Pose};
use serde::{Deserialize, Serialize};

/// Numbers of the action of an arm with the tool straight down: position of the TCP in the world
/// frame (m), gripper.
const SHORT: usize = 4;
/// With an orientation (w x y z) before the gripper.
const LONG: usize = 8;
/// Gripper of an action: below it opens, above it closes, and here it stays.
const KEEP: f32 = 0.5;
/// Farthest position of an action (m).
const MAX_POSITION_M: f64 = 100.0;
/// A quaternion may differ from length 1 by this, and is then normalised.
const LENGTH_TOLERANCE: f64 = 1.0e-2;
/// Within this the length of a quaternion of 32 bits differs from 1 by rounding alone.
const ROUNDED: f64 = 5.0e-7;

/// The action of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ArmAction {
    position: [f64; 3],
    /// `None`: the arm holds.
    orientation_wxyz: Option<[f64; 4]>,
    gripper: f32,
}

impl ArmAction {
    /// Where the TCP is sent, world frame (m); `None` for an arm that holds.
    pub(crate) fn position(&self) -> Option<[f64; 3]> {
        self.orientation_wxyz.map(|_| self.position)
    }

    /// The intent, with the force of a closing gripper (N).
    pub(crate) fn intent(&self, grip_force: f64) -> ArmIntent {
        let target = self.orientation_wxyz.map(|orientation_wxyz| Pose {
            position: self.position,
            orientation_wxyz,
        });
        ArmIntent {
            kind: target.map_or(GoalKind::Hold, |_| GoalKind::Pose),
            // One goal whose target moves, as an operator moves it.
            key: 1,
            target: target.unwrap_or(Pose::IDENTITY),
            gripper: match self.gripper {
                gripper if gripper < KEEP => GripperGoal::Open,
                gripper if gripper > KEEP => GripperGoal::Close,
                _ => GripperGoal::Keep,
            },
            grip_force,
            ..ArmIntent::default()
        }
    }
}

/// The actions in a row; `down` has for each arm the orientation of its tool straight down.
///
/// # Errors
/// A sentence about a row that the arms cannot execute.
pub(crate) fn of_row(row: &[f32], down: &[[f64; 4]]) -> Result<Vec<ArmAction>, String> {
    let (short, long) = (SHORT * down.len(), LONG * down.len());
    if row.len() != short && row.len() != long {
        return Err(format!(
            "a row of \"actions\" has {} numbers; {short} (TCP position, gripper) or {long} \
             (position, quaternion wxyz, gripper) are needed",
            row.len()
        ));
    }
    let parts = row.chunks(row.len() / down.len().max(1));
    let parts = parts.zip(down);
    parts.map(|(part, down)| of_arm(part, *down)).collect()
}

/// The action of an arm, from 4 or 8 numbers.
fn of_arm(part: &[f32], down: [f64; 4]) -> Result<ArmAction, String> {
    let numbers: Vec<f64> = part.iter().copied().map(f64::from).collect();
    let position = numbers.first_chunk::<3>().copied().unwrap_or_default();
    if let Some(far) = position.iter().find(|number| number.abs() > MAX_POSITION_M) {
        return Err(format!(
            "the position {far} m of an action is beyond {MAX_POSITION_M} m"
        ));
    }
    let quaternion = numbers.get(3..7).map(<[f64; 4]>::try_from);
    let orientation = match quaternion.and_then(Result::ok) {
        None => Some(down),
        // As in a data set: an arm that holds.
        Some([0.0, 0.0, 0.0, 0.0]) => None,
        Some(quaternion) => Some(unit(quaternion)?),
    };
    Ok(ArmAction {
        position,
        orientation_wxyz: orientation,
        gripper: part.last().copied().unwrap_or(KEEP),
    })
}

fn unit(quaternion: [f64; 4]) -> Result<[f64; 4], String> {
    let square: f64 = quaternion.iter().map(|part| part * part).sum();
    let length = square.sqrt();
    if (length - 1.0).abs() > LENGTH_TOLERANCE {
        return Err(format!(
            "the quaternion of an action has the length {length}; 1 is needed"
        ));
    }
    // One of 32 bits is executed as it is: then a recorded action gives its states again.
    if (length - 1.0).abs() < ROUNDED {
        return Ok(quaternion);
    }
    Ok(quaternion.map(|part| part / length))
}
