//! Limits of a joint as a URDF gives them.

/// Limits of one joint in its URDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UrdfLimits {
    /// Velocity (rad/s or m/s); 0 if the file has none.
    pub velocity: f64,
    /// Effort (N·m or N); 0 if the file has none.
    pub effort: f64,
    /// Acceleration (rad/s², m/s²), if the file has it.
    pub acceleration: Option<f64>,
    /// Jerk (rad/s³, m/s³), if the file has it.
    pub jerk: Option<f64>,
}
