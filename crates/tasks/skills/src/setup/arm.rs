//! An arm of the cell and its tool.

use cell_model::{ArmSpec, Cell, Robot};
use ipc_types::{MAX_JOINTS, Pose};
use nalgebra::Vector3;
use robocell_task::SetupError;

use super::object::ObjectSetup;
use crate::geometry;

/// Index of the arm of a job with one arm.
pub const ARM: usize = 0;

/// Share of the length of the stretched arm that it reaches with the tool straight down.
const REACH_SHARE: f64 = 0.9;
/// Fingers within this of the open width are open (m).
const OPEN_TOLERANCE_M: f64 = 0.008;

/// The tool of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tool {
    /// Two fingers; the TCP's z axis points out of the hand.
    Fingers {
        /// Width of the open hand (m).
        open_width_m: f64,
        /// Fingers within this of the open width are open (m).
        open_tolerance_m: f64,
        /// Force per finger (N).
        force_n: f64,
    },
    /// A suction cup; the TCP's x axis points out of it.
    Suction,
    /// No gripper; the TCP's z axis counts as its direction.
    None,
}

impl Tool {
    /// The tool of a robot.
    pub fn of(robot: &Robot) -> Self {
        match (&robot.gripper, &robot.suction) {
            (Some(gripper), _) => Self::Fingers {
                open_width_m: gripper.max_width,
                open_tolerance_m: OPEN_TOLERANCE_M,
                force_n: gripper.default_force,
            },
            (None, Some(_)) => Self::Suction,
            (None, None) => Self::None,
        }
    }

    /// Direction out of the tool, in the frame of the TCP.
    pub fn axis(self) -> Vector3<f64> {
        match self {
            Self::Suction => Vector3::x(),
            Self::Fingers { .. } | Self::None => Vector3::z(),
        }
    }

    /// Orientation of the TCP with the tool straight down, turned by `yaw`
    /// about the vertical axis (rad); w x y z.
    pub fn down(self, yaw: f64) -> [f64; 4] {
        match self {
            Self::Suction => geometry::straight_down_by_x(yaw),
            Self::Fingers { .. } | Self::None => geometry::straight_down(yaw),
        }
    }

    /// The inverse of [`Tool::down`] (rad).
    pub fn yaw(self, orientation_wxyz: [f64; 4]) -> f64 {
        let rotation = geometry::rotation(orientation_wxyz);
        let axis = match self {
            Self::Suction => rotation * Vector3::z(),
            Self::Fingers { .. } | Self::None => rotation * Vector3::x(),
        };
        libm::atan2(axis.y, axis.x)
    }

    /// Height of the TCP above the centre of an object that is gripped from
    /// above (m).
    pub fn grasp_height(self, object: &ObjectSetup) -> f64 {
        match self {
            Self::Suction => object.half_height_m,
            Self::Fingers { .. } | Self::None => 0.0,
        }
    }
}

/// An arm of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmSetup {
    /// Its name in the cell file.
    pub name: String,
    /// Client programs command it: for the task it is absent, and reaches nothing.
    pub is_absent: bool,
    /// Its base, world frame (m).
    pub base: Vector3<f64>,
    /// Its joint positions at the start (rad or m).
    pub home: [f64; MAX_JOINTS],
    /// Its gripper.
    pub tool: Tool,
    /// Force at which the grip of its cup breaks (N); `None` without a cup.
    pub suction_limit_n: Option<f64>,
    /// Torque at which it breaks (N m).
    pub suction_limit_n_m: Option<f64>,
    /// An object farther from the base in the plane is out of reach (m).
    pub reach_m: f64,
    /// Pose of the TCP while the arm waits for a zone in which another arm works: the pose at
    /// the start, unless the job sets another. World frame.
    pub wait: Pose,
}

impl ArmSetup {
    /// Whether the arm reaches a point with the tool straight down (m).
    pub fn reaches(&self, point: Vector3<f64>) -> bool {
        self.is_within(point, self.reach_m)
    }

    /// Whether a point is within `reach_m` (m) of the base, in the plane and in height.
    pub fn is_within(&self, point: Vector3<f64>, reach_m: f64) -> bool {
        let off = point - self.base;
        !self.is_absent && off.xy().norm() <= reach_m && off.z.abs() <= reach_m
    }

    /// Whether a joint is more than half a turn from its position at the start: the elbow or
    /// the wrist is in another branch, or wound up.
    pub fn is_wound(&self, joint_positions: &[f64; MAX_JOINTS]) -> bool {
        let off = self.home.iter().zip(joint_positions).map(|(a, b)| a - b);
        off.into_iter().any(|off| off.abs() > std::f64::consts::PI)
    }

    /// The setup of `spec`.
    pub fn of(spec: &ArmSpec) -> Self {
        let mut home = [0.0; MAX_JOINTS];
        for (slot, position) in home.iter_mut().zip(&spec.home) {
            *slot = *position;
        }
        let all = spec.robot.with_arm_positions(&spec.home);
        let tcp = spec.robot.frame_pose(spec.robot.tcp_frame, &all);
        let tcp = spec.base * tcp.unwrap_or_default();
        let orientation = tcp.rotation.quaternion();
        Self {
            wait: Pose {
                position: tcp.translation.vector.into(),
                orientation_wxyz: [orientation.w, orientation.i, orientation.j, orientation.k],
            },
            name: spec.name.clone(),
            is_absent: spec.has_client(),
            base: spec.base.translation.vector,
            home,
            tool: Tool::of(&spec.robot),
            suction_limit_n: spec.robot.suction.as_ref().map(|cup| cup.force_limit),
            suction_limit_n_m: spec.robot.suction.as_ref().map(|cup| cup.torque_limit),
            reach_m: reach(&spec.robot),
        }
    }
}

/// The links between the second joint and the last, stretched; the tool points down and adds
/// nothing.
fn reach(robot: &Robot) -> f64 {
    let joints = robot.chain.joints();
    let controlled = robot.arm_joints.iter().filter_map(|i| joints.get(*i));
    let stretched: f64 = controlled
        .skip(2)
        .map(|joint| joint.origin.translation.vector.norm())
        .sum();
    REACH_SHARE * stretched
}

/// The cell's first arm, which has a suction gripper.
///
/// # Errors
/// Returns a [`SetupError`] for a cell without one.
pub fn suction_arm(cell: &Cell) -> Result<&ArmSpec, SetupError> {
    let arm = cell.arms.get(ARM);
    let arm = arm.ok_or_else(|| SetupError::new(cell, "[[arm]] is missing; this job needs one"))?;
    if arm.robot.suction.is_none() {
        let name = &arm.robot.name;
        let problem = format!("robot '{name}' has no suction gripper; this job needs one");
        return Err(SetupError::new(cell, problem));
    }
    Ok(arm)
}
