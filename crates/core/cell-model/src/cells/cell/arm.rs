//! An arm of a cell, with its robot.

use nalgebra::Isometry3;

use super::pose::pose;
use crate::cells::check_file;
use crate::cells::file::ArmTable;
use crate::check::Checker;
use crate::data::Data;
use crate::error::ModelError;
use crate::robots::files::RobotFiles;
use crate::robots::robot::Robot;
use crate::suggest;

/// An arm of a cell.
#[derive(Clone, Debug)]
pub struct ArmSpec {
    /// Name in the cell.
    pub name: String,
    /// The robot.
    pub robot: Robot,
    /// Pose of its base in the world frame.
    pub base: Isometry3<f64>,
    /// Controlled joints at the start (rad or m).
    pub home: Vec<f64>,
    /// Whether it follows planned paths where its goal is behind something (ADR 0021).
    pub planner: bool,
    /// Program with its controllers, if it is not the built-in one.
    pub controller: Option<String>,
}

/// Controller of an arm that client programs command over the network.
pub const CLIENT_CONTROLLER: &str = "fci";

impl ArmSpec {
    /// Whether client programs command it over the network: no task does.
    pub fn has_client(&self) -> bool {
        self.controller.as_deref() == Some(CLIENT_CONTROLLER)
    }
}

/// The arm of a table, number `index` of the cell file, with the robot of the table or with
/// `robot` in its place.
pub(super) fn load_arm(
    data: &Data,
    (file, text): (&str, &str),
    (index, arm): (usize, &ArmTable),
    robot: Option<&RobotFiles>,
) -> Result<ArmSpec, ModelError> {
    let loaded = match robot {
        Some(RobotFiles {
            name: Some(name), ..
        }) => Robot::load(data, name)?,
        Some(files) => Robot::from_files(files)?,
        None => named_robot(data, &Checker::new(file, text), index, &arm.robot)?,
    };
    // The home position of the file belongs to the robot of the file, not to one given
    // in its place.
    let home = match (&arm.home_joint_positions, robot) {
        (Some(home), None) => home.clone(),
        _ => loaded.home(),
    };
    check_file::home(file, text, index, &home, &loaded)?;
    Ok(ArmSpec {
        name: arm.name.clone(),
        base: pose(arm.base_position_m, arm.base_yaw_rad),
        robot: loaded,
        home,
        planner: arm.planner,
        controller: arm.controller.clone(),
    })
}

/// The robot that an arm names; an unknown name is an error of the cell file.
fn named_robot(data: &Data, at: &Checker<'_>, arm: usize, name: &str) -> Result<Robot, ModelError> {
    let known = data.robot_names();
    if known.iter().any(|known| known == name) {
        return Robot::load(data, name);
    }
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let allowed = format!("no such robot; {}", suggest::advice(name, &known));
    Err(at.refuse(&format!("arm.{arm}.robot"), format!("'{name}'"), allowed))
}
