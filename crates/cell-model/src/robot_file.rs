//! `robots/NAME/robot.toml`: what a URDF cannot say.

use serde::Deserialize;

use crate::error::{ModelError, Place};
use crate::toml_text;

/// The whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RobotFile {
    pub(crate) name: String,
    pub(crate) urdf: String,
    pub(crate) xrdf: String,
    pub(crate) rmpflow: String,
    pub(crate) tcp_frame: String,
    pub(crate) arm: ArmTable,
    pub(crate) gripper: Option<GripperTable>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ArmTable {
    pub(crate) joints: Vec<String>,
    pub(crate) home_joint_positions: Vec<f64>,
    pub(crate) acceleration_limits: Vec<f64>,
    pub(crate) jerk_limits: Vec<f64>,
    pub(crate) drive: DriveTable,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DriveTable {
    pub(crate) stiffness: Vec<f64>,
    pub(crate) damping: Vec<f64>,
    pub(crate) armature: Vec<f64>,
    pub(crate) joint_damping: Vec<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct GripperTable {
    pub(crate) finger_joints: [String; 2],
    pub(crate) max_width_m: f64,
    pub(crate) default_force_n: f64,
    pub(crate) max_force_n: f64,
    pub(crate) speed_m_s: f64,
    pub(crate) stiffness_n_per_m: f64,
    pub(crate) damping_n_s_per_m: f64,
    pub(crate) armature_kg: f64,
    pub(crate) joint_damping_n_s_per_m: f64,
    pub(crate) pad_friction: f64,
}

/// Reads and checks the file.
pub(crate) fn parse(file: &str, text: &str) -> Result<RobotFile, ModelError> {
    let robot: RobotFile = toml_text::parse(file, text)?;
    let checker = Checker { file, text };
    let joints = robot.arm.joints.len();
    if joints == 0 || joints > ipc_types::MAX_JOINTS {
        return Err(checker.refuse(
            "arm.joints",
            joints,
            format!("1 to {} joints are needed", ipc_types::MAX_JOINTS),
        ));
    }
    let drive = &robot.arm.drive;
    checker.list(
        "arm.home_joint_positions",
        &robot.arm.home_joint_positions,
        joints,
        -100.0,
        100.0,
    )?;
    checker.list(
        "arm.acceleration_limits",
        &robot.arm.acceleration_limits,
        joints,
        1.0e-3,
        1.0e4,
    )?;
    checker.list(
        "arm.jerk_limits",
        &robot.arm.jerk_limits,
        joints,
        1.0e-2,
        1.0e6,
    )?;
    checker.list("arm.drive.stiffness", &drive.stiffness, joints, 1.0, 1.0e6)?;
    checker.list("arm.drive.damping", &drive.damping, joints, 0.0, 1.0e5)?;
    checker.list("arm.drive.armature", &drive.armature, joints, 1.0e-4, 1.0e2)?;
    checker.list(
        "arm.drive.joint_damping",
        &drive.joint_damping,
        joints,
        0.0,
        1.0e3,
    )?;
    if let Some(gripper) = &robot.gripper {
        checker.gripper(gripper)?;
    }
    Ok(robot)
}

struct Checker<'a> {
    file: &'a str,
    text: &'a str,
}

impl Checker<'_> {
    fn refuse(&self, key: &str, value: impl std::fmt::Display, allowed: String) -> ModelError {
        ModelError::value(
            Place::line(self.file, toml_text::line_of(self.text, key)),
            key,
            value,
            allowed,
        )
    }

    fn number(&self, key: &str, value: f64, low: f64, high: f64) -> Result<(), ModelError> {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(self.refuse(key, value, format!("{low} to {high} is allowed")))
    }

    fn list(
        &self,
        key: &str,
        values: &[f64],
        count: usize,
        low: f64,
        high: f64,
    ) -> Result<(), ModelError> {
        if values.len() != count {
            return Err(self.refuse(
                key,
                format!("{} numbers", values.len()),
                format!("{count} are needed, one for each of arm.joints"),
            ));
        }
        values.iter().enumerate().try_for_each(|(index, value)| {
            self.number(&format!("{key}.{index}"), *value, low, high)
        })
    }

    fn gripper(&self, gripper: &GripperTable) -> Result<(), ModelError> {
        self.number("gripper.max_width_m", gripper.max_width_m, 1.0e-3, 1.0)?;
        self.number("gripper.max_force_n", gripper.max_force_n, 0.1, 1.0e4)?;
        self.number(
            "gripper.default_force_n",
            gripper.default_force_n,
            0.1,
            gripper.max_force_n,
        )?;
        self.number("gripper.speed_m_s", gripper.speed_m_s, 1.0e-3, 10.0)?;
        self.number(
            "gripper.stiffness_n_per_m",
            gripper.stiffness_n_per_m,
            1.0,
            1.0e6,
        )?;
        self.number(
            "gripper.damping_n_s_per_m",
            gripper.damping_n_s_per_m,
            0.0,
            1.0e5,
        )?;
        self.number("gripper.armature_kg", gripper.armature_kg, 1.0e-4, 10.0)?;
        self.number(
            "gripper.joint_damping_n_s_per_m",
            gripper.joint_damping_n_s_per_m,
            0.0,
            1.0e3,
        )?;
        self.number("gripper.pad_friction", gripper.pad_friction, 0.0, 5.0)
    }
}
