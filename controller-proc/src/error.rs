//! Why an arm cannot be controlled.

/// Why an arm cannot be controlled.
#[derive(Debug, thiserror::Error)]
pub enum RmpFlowError {
    /// The cell has no such arm.
    #[error("the cell has no arm number {0}; arms count from 0 in the order of the cell file")]
    NoSuchArm(usize),
    /// Robot and tuning do not fit.
    #[error("robot '{robot}': {source}; check its RMPflow file and its spheres")]
    Setup {
        /// The robot.
        robot: String,
        /// The contradiction.
        source: rmp::SetupError,
    },
    /// An obstacle of the cell cannot be one.
    #[error("fixture '{fixture}': {source}")]
    Obstacle {
        /// The fixture.
        fixture: String,
        /// The reason.
        source: rmp::ObstacleError,
    },
    /// An object of the cell cannot be an obstacle.
    #[error("object '{object}': {source}")]
    Object {
        /// The object.
        object: String,
        /// The reason.
        source: rmp::ObstacleError,
    },
    /// Another arm of the cell cannot be kept away from.
    #[error("collision spheres of arm '{arm}': {source}; check them in its XRDF")]
    OtherArm {
        /// The other arm.
        arm: String,
        /// The reason.
        source: rmp::ObstacleError,
    },
    /// The planner does not know the robot.
    #[error("robot '{robot}': {source}; check its URDF and its XRDF")]
    Planner {
        /// The robot.
        robot: String,
        /// The reason.
        source: plan::BodyError,
    },
    /// The robot's limits cannot be kept.
    #[error("robot '{robot}': {source}")]
    Limits {
        /// The robot.
        robot: String,
        /// The reason.
        source: rmp::LimitsError,
    },
}
