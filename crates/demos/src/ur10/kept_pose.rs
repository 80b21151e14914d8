//! A pose as a checkpoint keeps it.

use ipc_types::Pose;
use ipc_types::validate::MAX_POSITION_M;
use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use super::pose;

/// A quaternion of a cell file has four decimals: its norm is one up to this.
const UNIT: f64 = 1.0e-4;

/// A pose as plain data; in which frame, its field says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptPose {
    /// Position (m).
    pub position: [f64; 3],
    /// Unit quaternion, w x y z.
    pub orientation_wxyz: [f64; 4],
}

impl KeptPose {
    /// To calculate with.
    pub fn isometry(&self) -> Isometry3<f64> {
        pose::isometry(&(*self).into())
    }

    /// Whether a restored pose is one: a place in a cell, a unit quaternion.
    pub fn is_sound(&self) -> bool {
        let norm = nalgebra::Vector4::from(self.orientation_wxyz).norm();
        within(&self.position, MAX_POSITION_M) && (norm - 1.0).abs() <= UNIT
    }
}

/// Whether restored numbers are finite and not beyond `limit`.
pub(crate) fn within(values: &[f64], limit: f64) -> bool {
    values.iter().all(|value| value.abs() <= limit)
}

impl From<Pose> for KeptPose {
    fn from(pose: Pose) -> Self {
        Self {
            position: pose.position,
            orientation_wxyz: pose.orientation_wxyz,
        }
    }
}

impl From<&Isometry3<f64>> for KeptPose {
    fn from(at: &Isometry3<f64>) -> Self {
        pose::wire(at).into()
    }
}

impl From<KeptPose> for Pose {
    fn from(kept: KeptPose) -> Self {
        pose::with_unit_quaternion(&Self {
            position: kept.position,
            orientation_wxyz: kept.orientation_wxyz,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_pose_is_not_sound() {
        let kept = KeptPose::from(Pose::IDENTITY);
        assert!(kept.is_sound());
        let at = |position| KeptPose { position, ..kept };
        assert!(!at([0.0, f64::NAN, 0.0]).is_sound());
        assert!(!at([0.0, 0.0, -1.0e4]).is_sound());
        let turned = |orientation_wxyz| KeptPose {
            orientation_wxyz,
            ..kept
        };
        assert!(!turned([0.0; 4]).is_sound());
        assert!(!turned([f64::INFINITY, 0.0, 0.0, 0.0]).is_sound());
    }
}
