//! A user's own arm.

use std::path::PathBuf;

use crate::data;
use crate::error::ModelError;
use crate::robot::Robot;

/// Files of a user's arm (`--robot`, `--xrdf`, `--rmpflow`).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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
        let file = files.urdf.display().to_string();
        let urdf = crate::urdf::parse(&file, &data::read_text(&files.urdf)?)?;
        Ok(assemble(urdf))
    }
}

fn assemble(urdf: crate::urdf::UrdfRobot) -> Robot {
    let joints = crate::robot_load::plain_specs(&urdf);
    let arm_joints = longest_arm(&urdf.chain);
    let home: Vec<f64> = joints.iter().map(|spec| spec.home).collect();
    Robot {
        name: urdf.name,
        default_joint_positions: arm_joints.iter().map(|&joint| home[joint]).collect(),
        fixed_joint_positions: home,
        tcp_frame: tool_frame(&urdf.chain, arm_joints.last().copied()),
        chain: urdf.chain,
        joints,
        links: urdf.links,
        arm_joints,
        gripper: None,
        spheres: Vec::new(),
    }
}

/// Joints from the base to where the tree ends or branches: a hand with several
/// fingers begins at a branch.
fn longest_arm(chain: &rmp::Chain) -> Vec<usize> {
    let children = |parent: Option<usize>| -> Vec<usize> {
        (0..chain.joints().len()).filter(|&joint| chain.joints()[joint].parent == parent).collect()
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
    let named = usual.iter().find_map(|name| chain.frame_index(name).filter(on_joint));
    let last = (0..chain.frames().len()).rfind(on_joint);
    named.or(last).unwrap_or(0)
}
