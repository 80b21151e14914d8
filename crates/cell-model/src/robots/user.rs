//! A user's own arm.

use std::path::PathBuf;

use crate::error::{Location, ModelError};
use crate::robots::motion::read;
use crate::robots::robot::Robot;
use crate::robots::xrdf::{self, Xrdf};
use crate::suggest;

/// Files of a user's arm (`--robot`, `--xrdf`, `--rmpflow`).
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RobotFiles {
    /// The URDF.
    pub urdf: PathBuf,
    /// The XRDF: controlled joints, limits, tool frame, spheres.
    pub xrdf: Option<PathBuf>,
    /// Tuning, `format: rmpflow`.
    pub rmpflow: Option<PathBuf>,
}

impl Robot {
    /// Loads a user's arm.
    ///
    /// # Errors
    /// [`ModelError`] where a file is missing or wrong.
    pub fn from_files(files: &RobotFiles) -> Result<Self, ModelError> {
        let (file, text) = read(&files.urdf)?;
        let urdf = crate::robots::urdf::parse(&file, &text)?;
        let xrdf = match &files.xrdf {
            None => None,
            Some(path) => {
                let (file, text) = read(path)?;
                let xrdf = xrdf::parse(&file, &text)?;
                Some((file, xrdf))
            }
        };
        let mut robot = assemble(
            urdf,
            xrdf.as_ref().map(|(file, xrdf)| (file.as_str(), xrdf)),
        )?;
        if let Some(path) = &files.rmpflow {
            let (file, text) = read(path)?;
            robot.take_tuning(&file, &text)?;
        }
        Ok(robot)
    }
}

fn assemble(
    urdf: crate::robots::urdf::UrdfRobot,
    xrdf: Option<(&str, &Xrdf)>,
) -> Result<Robot, ModelError> {
    let joints = crate::robots::load::plain_specs(&urdf);
    let arm_joints = match xrdf {
        None => longest_arm(&urdf.chain),
        Some((file, xrdf)) => named_joints(&urdf.chain, file, &xrdf.joint_names)?,
    };
    let home: Vec<f64> = joints.iter().map(|spec| spec.home).collect();
    let mut robot = Robot {
        rmpflow: Robot::general_tuning(arm_joints.len())?,
        name: urdf.name,
        default_joint_positions: arm_joints.iter().map(|&joint| home[joint]).collect(),
        fixed_joint_positions: home,
        tcp_frame: tool_frame(&urdf.chain, arm_joints.last().copied()),
        chain: urdf.chain,
        joints,
        links: urdf.links,
        arm_joints,
        gripper: None,
        suction: None,
        spheres: Vec::new(),
    };
    if let Some((file, xrdf)) = xrdf {
        robot.take_xrdf(file, xrdf)?;
        robot.take_tool(file, xrdf)?;
        // A user's arm starts in its default posture.
        for (spec, position) in robot.joints.iter_mut().zip(&robot.fixed_joint_positions) {
            spec.home = *position;
        }
    }
    Ok(robot)
}

fn named_joints(
    chain: &rmp::Chain,
    file: &str,
    names: &[String],
) -> Result<Vec<usize>, ModelError> {
    let known: Vec<&str> = chain
        .joints()
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    let index = |name: &String| {
        chain.joint_index(name).ok_or_else(|| {
            let allowed = format!(
                "no such moving joint in the URDF; {}",
                suggest::advice(name, &known)
            );
            ModelError::value(Location::file(file), "cspace.joint_names", name, allowed)
        })
    };
    names.iter().map(index).collect()
}

/// Joints from the base to where the tree ends or branches: a hand with several
/// fingers begins at a branch.
fn longest_arm(chain: &rmp::Chain) -> Vec<usize> {
    let children = |parent: Option<usize>| -> Vec<usize> {
        (0..chain.joints().len())
            .filter(|&joint| chain.joints()[joint].parent == parent)
            .collect()
    };
    let mut arm = Vec::new();
    let mut at = None;
    while let [next] = children(at)[..] {
        arm.push(next);
        at = Some(next);
        if arm.len() == ipc_types::MAX_JOINTS {
            break;
        }
    }
    arm
}

/// A frame on the last joint with a usual name, else the last one there.
fn tool_frame(chain: &rmp::Chain, joint: Option<usize>) -> usize {
    let on_joint = |index: &usize| chain.frames()[*index].joint == joint;
    let usual = ["tcp", "tool0", "ee_link", "tool", "flange"];
    let named = usual
        .iter()
        .find_map(|name| chain.frame_index(name).filter(on_joint));
    let last = (0..chain.frames().len()).rfind(on_joint);
    named.or(last).unwrap_or(0)
}
