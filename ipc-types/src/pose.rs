//! Poses and twists in messages.

use crate::validate::{Check, Invalid};
use crate::wire::wire;

wire! {
    /// A rigid transform: a frame seen from a parent frame (the field that
    /// holds the pose names both).
    pub struct Pose {
        /// Metres.
        pub position: [f64; 3],
        /// Unit quaternion, w x y z.
        pub orientation_wxyz: [f64; 4],
    }
}

wire! {
    /// Velocity of a body, in the world frame.
    pub struct Twist {
        /// Metres per second.
        pub linear: [f64; 3],
        /// Radians per second.
        pub angular: [f64; 3],
    }
}

impl Pose {
    /// No translation, no rotation.
    pub const IDENTITY: Self = Self {
        position: [0.0; 3],
        orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
    };

    pub(crate) fn check(&self) -> Result<(), Invalid> {
        Check::within("position", &self.position, crate::validate::MAX_POSITION_M)?;
        // A quaternion of another length would scale every vector it turns.
        Check::unit_quaternion("orientation_wxyz", &self.orientation_wxyz)
    }
}

impl Twist {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        Check::within("linear", &self.linear, crate::validate::MAX_SPEED_M_S)?;
        Check::within("angular", &self.angular, crate::validate::MAX_RATE_RAD_S)
    }
}
