//! Joint values, with a mark for each joint that has one.

use thiserror::Error;

use crate::checkpoint::{CheckpointError, Codec};

/// Joints a state can hold: those of an arm and its gripper.
// The 16 controlled joints of a message and the fingers; a bit of 32 for each.
pub const MAX_STATE_JOINTS: usize = 24;

/// Values of one kind for some joints of a [`JointSpace`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointField {
    set: u32,
    values: [f64; MAX_STATE_JOINTS],
}

impl JointField {
    /// No joint has a value.
    pub const EMPTY: Self = Self {
        set: 0,
        values: [0.0; MAX_STATE_JOINTS],
    };

    /// Sets the value of a joint; indices beyond [`MAX_STATE_JOINTS`] are left
    /// out.
    pub fn set(&mut self, joint: usize, value: f64) {
        if let Some(slot) = self.values.get_mut(joint) {
            *slot = value;
            self.set |= 1 << joint;
        }
    }

    /// Sets the values of the joints from `first` on.
    pub fn set_from(&mut self, first: usize, values: &[f64]) {
        for (offset, value) in values.iter().enumerate() {
            self.set(first + offset, *value);
        }
    }

    /// The value of a joint, if it has one.
    pub fn get(&self, joint: usize) -> Option<f64> {
        let value = self.values.get(joint)?;
        (self.set & (1 << joint) != 0).then_some(*value)
    }

    /// The first `count` values; joints without one read zero.
    pub fn first(&self, count: usize) -> &[f64] {
        &self.values[..count.min(MAX_STATE_JOINTS)]
    }

    fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        codec.u32(&mut self.set)?;
        codec.f64s(&mut self.values)
    }

    fn combine(&self, other: &Self, kind: &'static str) -> Result<Self, CombineError> {
        // Two controllers of one joint are refused: the later one would win without notice.
        let both = self.set & other.set;
        if both != 0 {
            return Err(CombineError {
                joint: both.trailing_zeros() as usize,
                kind,
            });
        }
        let mut sum = *self;
        for joint in 0..MAX_STATE_JOINTS {
            if let Some(value) = other.get(joint) {
                sum.set(joint, value);
            }
        }
        Ok(sum)
    }
}

/// State of a robot, or of some of its joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotState {
    /// rad or m.
    pub positions: JointField,
    /// rad/s or m/s.
    pub velocities: JointField,
    /// rad/s² or m/s².
    pub accelerations: JointField,
}

/// Two controllers want the same joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("two controllers write the {kind} of joint {joint}; give each joint to one controller")]
pub struct CombineError {
    /// Index in the joint space.
    pub joint: usize,
    /// Which values.
    pub kind: &'static str,
}

impl RobotState {
    /// Nothing about any joint.
    pub const EMPTY: Self = Self {
        positions: JointField::EMPTY,
        velocities: JointField::EMPTY,
        accelerations: JointField::EMPTY,
    };

    /// Writes or reads all of it.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        self.positions.checkpoint(codec)?;
        self.velocities.checkpoint(codec)?;
        self.accelerations.checkpoint(codec)
    }

    /// The union of both.
    ///
    /// # Errors
    ///
    /// If both have a value for the same joint.
    pub fn combine(&self, other: &Self) -> Result<Self, CombineError> {
        Ok(Self {
            positions: self.positions.combine(&other.positions, "positions")?,
            velocities: self.velocities.combine(&other.velocities, "velocities")?,
            accelerations: self
                .accelerations
                .combine(&other.accelerations, "accelerations")?,
        })
    }
}

/// Names of the joints by index: those of the arm, then those of the gripper.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JointSpace {
    names: Vec<String>,
}

impl JointSpace {
    /// A space of these joints; at most [`MAX_STATE_JOINTS`].
    pub fn new(names: Vec<String>) -> Option<Self> {
        (names.len() <= MAX_STATE_JOINTS).then_some(Self { names })
    }

    /// Index of a joint.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    /// Name of a joint.
    pub fn name(&self, joint: usize) -> Option<&str> {
        self.names.get(joint).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arm_and_gripper_combine_but_two_writers_of_a_joint_do_not() {
        let space = JointSpace::new(vec!["arm".to_owned(), "finger".to_owned()]).unwrap();
        let (mut arm, mut finger) = (RobotState::EMPTY, RobotState::EMPTY);
        arm.positions.set(space.index("arm").unwrap(), 1.0);
        finger.positions.set(space.index("finger").unwrap(), 0.04);
        let both = arm.combine(&finger).unwrap();
        assert_eq!(both.positions.first(2), [1.0, 0.04]);
        assert_eq!(both.velocities.get(0), None);
        let error = both.combine(&finger).unwrap_err();
        assert_eq!(
            (space.name(error.joint), error.kind),
            (Some("finger"), "positions")
        );
    }
}
