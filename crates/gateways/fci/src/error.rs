//! The 41 errors of the robot, in the order of their flags (libfranka-common,
//! `research_interface/robot/error.h`).

use serde::{Deserialize, Serialize};

/// Number of errors.
pub const ERROR_COUNT: usize = 41;

const NAMES: [&str; ERROR_COUNT] = [
    "joint_position_limits_violation",
    "cartesian_position_limits_violation",
    "self_collision_avoidance_violation",
    "joint_velocity_violation",
    "cartesian_velocity_violation",
    "force_control_safety_violation",
    "joint_reflex",
    "cartesian_reflex",
    "max_goal_pose_deviation_violation",
    "max_path_pose_deviation_violation",
    "cartesian_velocity_profile_safety_violation",
    "joint_position_motion_generator_start_pose_invalid",
    "joint_motion_generator_position_limits_violation",
    "joint_motion_generator_velocity_limits_violation",
    "joint_motion_generator_velocity_discontinuity",
    "joint_motion_generator_acceleration_discontinuity",
    "cartesian_position_motion_generator_start_pose_invalid",
    "cartesian_motion_generator_elbow_limit_violation",
    "cartesian_motion_generator_velocity_limits_violation",
    "cartesian_motion_generator_velocity_discontinuity",
    "cartesian_motion_generator_acceleration_discontinuity",
    "cartesian_motion_generator_elbow_sign_inconsistent",
    "cartesian_motion_generator_start_elbow_invalid",
    "force_controller_desired_force_tolerance_violation",
    "start_elbow_sign_inconsistent",
    "communication_constraints_violation",
    "power_limit_violation",
    "cartesian_motion_generator_joint_position_limits_violation",
    "cartesian_motion_generator_joint_velocity_limits_violation",
    "cartesian_motion_generator_joint_velocity_discontinuity",
    "cartesian_motion_generator_joint_acceleration_discontinuity",
    "cartesian_position_motion_generator_invalid_frame",
    "controller_torque_discontinuity",
    "joint_p2p_insufficient_torque_for_planning",
    "tau_j_range_violation",
    "instability_detected",
    "joint_move_in_wrong_direction",
    "cartesian_spline_motion_generator_violation",
    "joint_via_motion_generator_planning_joint_limit_violation",
    "base_acceleration_initialization_timeout",
    "base_acceleration_invalid_reading",
];

/// An error, by the number of its flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Error(u8);

impl Error {
    /// A measured joint is outside of its limits.
    pub const JOINT_POSITION: Self = Self(0);
    /// Two parts of the arm would touch.
    pub const SELF_COLLISION: Self = Self(2);
    /// A measured joint is too fast.
    pub const JOINT_VELOCITY: Self = Self(3);
    /// The end effector as measured is too fast.
    pub const CARTESIAN_VELOCITY: Self = Self(4);
    /// The first commanded joint positions are not those of the robot.
    pub const START_POSE: Self = Self(11);
    /// A commanded joint position is outside of its limits.
    pub const POSITION_LIMIT: Self = Self(12);
    /// A commanded joint velocity is above its limit.
    pub const VELOCITY_LIMIT: Self = Self(13);
    /// A commanded joint acceleration is above its limit.
    pub const VELOCITY_DISCONTINUITY: Self = Self(14);
    /// A commanded joint jerk is above its limit.
    pub const ACCELERATION_DISCONTINUITY: Self = Self(15);
    /// The first commanded pose is not that of the robot.
    pub const CARTESIAN_START_POSE: Self = Self(16);
    /// A commanded elbow is outside of the limits of joint 3.
    pub const ELBOW_LIMIT: Self = Self(17);
    /// A commanded velocity of the end effector is above its limit.
    pub const CARTESIAN_VELOCITY_LIMIT: Self = Self(18);
    /// A commanded acceleration of the end effector is above its limit.
    pub const CARTESIAN_VELOCITY_DISCONTINUITY: Self = Self(19);
    /// A commanded jerk of the end effector is above its limit.
    pub const CARTESIAN_ACCELERATION_DISCONTINUITY: Self = Self(20);
    /// A commanded elbow has the flip direction that joint 4 has not.
    pub const ELBOW_SIGN: Self = Self(21);
    /// The first commanded elbow is not that of the robot.
    pub const START_ELBOW: Self = Self(22);
    /// Twenty answers in a row were late or missing.
    pub const COMMUNICATION: Self = Self(25);
    /// The joint positions of a commanded pose are outside of their limits.
    pub const CARTESIAN_JOINT_POSITION: Self = Self(27);
    /// The joint velocities of a commanded pose are above their limits.
    pub const CARTESIAN_JOINT_VELOCITY: Self = Self(28);
    /// The joint accelerations of a commanded pose are above their limits.
    pub const CARTESIAN_JOINT_VELOCITY_DISCONTINUITY: Self = Self(29);
    /// The joint jerks of a commanded pose are above their limits.
    pub const CARTESIAN_JOINT_ACCELERATION_DISCONTINUITY: Self = Self(30);
    /// A commanded pose is not a rigid transformation.
    pub const INVALID_FRAME: Self = Self(31);
    /// A commanded torque changes too fast.
    pub const TORQUE_DISCONTINUITY: Self = Self(32);
    /// A commanded torque is above the limit of its joint.
    pub const TORQUE_RANGE: Self = Self(34);

    /// The name by which libfranka reports it.
    pub fn name(self) -> &'static str {
        NAMES.get(usize::from(self.0)).copied().unwrap_or("")
    }

    /// The flags with this error alone.
    pub fn flags(self) -> Errors {
        Errors(1 << self.0)
    }
}

/// A set of errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Errors(u64);

impl Errors {
    /// One byte for each error, 1 where it is set.
    pub fn bytes(self) -> [u8; ERROR_COUNT] {
        std::array::from_fn(|number| (self.0 >> number & 1) as u8)
    }

    /// Whether no error is set.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}
