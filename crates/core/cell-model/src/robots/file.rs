//! `robots/NAME/robot.toml`: data of a robot that a URDF does not have.

use serde::Deserialize;

use crate::error::{Location, ModelError};
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
    pub(crate) suction: Option<SuctionTable>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ArmTable {
    pub(crate) joints: Vec<String>,
    pub(crate) home_joint_positions: Vec<f64>,
    pub(crate) acceleration_limits: Vec<f64>,
    pub(crate) jerk_limits: Vec<f64>,
    #[serde(default)]
    pub(crate) velocity_offsets: Vec<f64>,
    #[serde(default)]
    pub(crate) deceleration_limits: Vec<f64>,
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

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SuctionTable {
    pub(crate) axis: [f64; 3],
    pub(crate) grip_distance_m: f64,
    pub(crate) force_limit_n: f64,
    pub(crate) torque_limit_n_m: f64,
    pub(crate) cup_radius_m: f64,
}

/// Reads and checks the file.
pub(crate) fn parse(file: &str, text: &str) -> Result<RobotFile, ModelError> {
    let robot: RobotFile = toml_text::parse(file, text)?;
    let checker = Checker { file, text };
    let joints = robot.arm.joints.len();
    // A state has room for this many joints (`ipc_types::MAX_JOINTS`).
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
    checker.envelope(&robot.arm, joints)?;
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
    if let Some(suction) = &robot.suction {
        checker.suction(suction, robot.gripper.is_some())?;
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
            Location::line(self.file, toml_text::line_of(self.text, key)),
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

    /// Offsets and decelerations are given together, or not at all.
    fn envelope(&self, arm: &ArmTable, joints: usize) -> Result<(), ModelError> {
        if arm.velocity_offsets.is_empty() && arm.deceleration_limits.is_empty() {
            return Ok(());
        }
        self.list(
            "arm.velocity_offsets",
            &arm.velocity_offsets,
            joints,
            0.0,
            10.0,
        )?;
        self.list(
            "arm.deceleration_limits",
            &arm.deceleration_limits,
            joints,
            1.0e-3,
            1.0e4,
        )
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

    fn suction(&self, suction: &SuctionTable, has_fingers: bool) -> Result<(), ModelError> {
        // Both would command one gripper with two meanings of open and close.
        if has_fingers {
            let allowed = "a robot has fingers or suction; remove [gripper] or [suction]";
            return Err(self.refuse("suction", "given beside gripper", allowed.to_owned()));
        }
        let length = nalgebra::Vector3::from(suction.axis).norm();
        // `contains` refuses NaN as well.
        if !(0.999..=1.001).contains(&length) {
            let [x, y, z] = suction.axis;
            let allowed = "a direction of length 1 in the TCP frame is needed, out of the cup";
            let value = format!("[{x}, {y}, {z}]");
            return Err(self.refuse("suction.axis", value, allowed.to_owned()));
        }
        let numbers = [
            ("grip_distance_m", suction.grip_distance_m, 1.0e-4, 0.1),
            ("force_limit_n", suction.force_limit_n, 0.1, 1.0e4),
            ("torque_limit_n_m", suction.torque_limit_n_m, 0.01, 1.0e4),
            ("cup_radius_m", suction.cup_radius_m, 1.0e-3, 0.5),
        ];
        numbers.into_iter().try_for_each(|(key, value, low, high)| {
            self.number(&format!("suction.{key}"), value, low, high)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UR10: &str = include_str!("../../../../../robots/ur10/robot.toml");
    const PANDA: &str = include_str!("../../../../../robots/panda/robot.toml");

    #[test]
    fn a_suction_cup_beyond_its_ranges_is_refused_with_its_line() {
        let cases = [
            (
                "force_limit_n = 50.0",
                "force_limit_n = nan",
                "suction.force_limit_n is nan",
            ),
            (
                "torque_limit_n_m = 5.0",
                "torque_limit_n_m = -5.0",
                "0.01 to 10000 is allowed",
            ),
            (
                "grip_distance_m = 0.01",
                "grip_distance_m = 1.0",
                "suction.grip_distance_m is 1",
            ),
            (
                "cup_radius_m = 0.02",
                "cup_radius_m = 0.0",
                "suction.cup_radius_m is 0",
            ),
            (
                "axis = [1.0, 0.0, 0.0]",
                "axis = [1.0, 1.0, 0.0]",
                "suction.axis is [1, 1, 0]",
            ),
            (
                "cup_radius_m",
                "cup_radios_m",
                "did you mean 'cup_radius_m'",
            ),
        ];
        for (from, to, wanted) in cases {
            let text = UR10.replacen(from, to, 1);
            assert_ne!(text, UR10, "{from}");
            let error = parse("a.toml", &text).unwrap_err().to_string();
            assert!(error.contains(wanted), "{error}");
            assert!(error.starts_with("a.toml:"), "{error}");
        }
    }

    #[test]
    fn fingers_and_suction_together_are_refused() {
        let suction = UR10.split("[suction]").nth(1).unwrap();
        let both = format!("{PANDA}\n[suction]{suction}");
        let error = parse("a.toml", &both).unwrap_err().to_string();
        assert!(error.contains("remove [gripper] or [suction]"), "{error}");
    }
}
