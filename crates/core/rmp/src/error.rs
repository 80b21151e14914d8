//! Errors in the data that a controller is built from.

use thiserror::Error;

/// Reason why an [`crate::RmpFlow`] cannot be built or refuses a value.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SetupError {
    /// No joint is controlled.
    #[error("no joint is controlled; name at least one")]
    NoJoints,
    /// A joint is named that the chain does not have.
    #[error("the robot has no actuated joint '{name}'")]
    UnknownJoint {
        /// The name.
        name: String,
    },
    /// A controlled joint is named twice.
    #[error("joint '{name}' is listed twice among the controlled joints")]
    RepeatedJoint {
        /// The name.
        name: String,
    },
    /// A frame is named that the chain does not have.
    #[error("the robot has no frame '{name}' ({wanted_by})")]
    UnknownFrame {
        /// The name.
        name: String,
        /// The user of the frame.
        wanted_by: String,
    },
    /// A list has the wrong length.
    #[error("{what} has {found} values, but {expected} joints are controlled")]
    Length {
        /// Which list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Number of controlled joints.
        expected: usize,
    },
    /// A number is NaN or infinite.
    #[error("{what} is {value}; it must be finite")]
    NotFinite {
        /// Which number.
        what: String,
        /// Its value.
        value: f64,
    },
    /// A tuning number is out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A joint's limits leave no room between their buffers.
    #[error("joint '{joint}' has limits [{lower}, {upper}]; a buffer of {buffer} leaves no room")]
    Buffer {
        /// Name of the joint.
        joint: String,
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
        /// The buffer.
        buffer: f64,
    },
    /// An obstacle cannot be used or does not fit.
    #[error(transparent)]
    Obstacle(#[from] crate::ObstacleError),
}

/// A number of the tuning is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{key} is {value}; allowed is {allowed}")]
pub struct ParameterError {
    /// Path of the key as in a `format: rmpflow` file.
    pub key: String,
    /// The value.
    pub value: f64,
    /// The allowed range in words.
    pub allowed: &'static str,
}

/// Reason why a controller refuses a step.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FlowError {
    /// A length or number of the state cannot be used.
    #[error(transparent)]
    State(#[from] SetupError),
    /// The limits cannot be used.
    #[error(transparent)]
    Limits(#[from] crate::LimitsError),
    /// The step is not a positive time.
    #[error("the step is {dt} s; it must be greater than 0 and at most 1 s")]
    Step {
        /// The step, s.
        dt: f64,
    },
}
