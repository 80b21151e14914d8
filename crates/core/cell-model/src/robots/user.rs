//! A user's own arm.

use std::path::Path;

use crate::error::{Location, ModelError};
use crate::robots::files::RobotFiles;
use crate::robots::lula;
use crate::robots::mimic;
use crate::robots::motion::read;
use crate::robots::movable::{MOST_CANDIDATES, TipOption};
use crate::robots::robot::Robot;
use crate::robots::urdf::{self, UrdfRobot};
use crate::robots::xrdf::{self, Xrdf};
use crate::suggest;

/// With fewer joints before a branch than this, the tree is not an arm with a hand.
const LEAST_TRUNK: usize = 4;

impl RobotFiles {
    /// If the robot is a `config.json` of Isaac Sim, the files that it names; files that were
    /// given beside it are kept.
    ///
    /// # Errors
    /// Returns [`ModelError`] if the file is missing or wrong.
    pub fn resolved(self) -> Result<Self, ModelError> {
        if self.urdf.extension().is_none_or(|end| end != "json") {
            return Ok(self);
        }
        let named = lula::read_config(&self.urdf)?;
        Ok(Self {
            urdf: named.urdf,
            name: None,
            xrdf: self.xrdf.or(named.xrdf),
            rmpflow: self.rmpflow.or(named.rmpflow),
            tip: self.tip.or(named.tip),
        })
    }
}

impl Robot {
    /// Loads a user's arm.
    ///
    /// # Errors
    /// Returns [`ModelError`] if a file is missing or wrong.
    pub fn from_files(files: &RobotFiles) -> Result<Self, ModelError> {
        let (file, text) = read(&files.urdf)?;
        let urdf = urdf::parse(&file, &text)?;
        let description = files.xrdf.as_deref().map(read_description).transpose()?;
        let mut source = Source {
            file: &file,
            urdf,
            description: description.as_ref(),
            tip: files.tip.as_deref(),
        };
        let mut robot = source.assemble()?;
        if let Some(path) = &files.rmpflow {
            let (file, text) = read(path)?;
            robot.take_tuning(&file, &text)?;
        }
        let option = match files.xrdf {
            None => TipOption::Flag,
            Some(_) => TipOption::FlagOnly,
        };
        robot.warn_if_tip_stays(&file, option);
        Ok(robot)
    }
}

/// A description, with its name in messages.
fn read_description(path: &Path) -> Result<(String, Xrdf), ModelError> {
    let (file, text) = read(path)?;
    let parse = if lula::is_description(&text) {
        lula::parse
    } else {
        xrdf::parse
    };
    let description = parse(&file, &text)?;
    Ok((file, description))
}

/// The sources of a user's arm.
struct Source<'a> {
    file: &'a str,
    urdf: UrdfRobot,
    description: Option<&'a (String, Xrdf)>,
    tip: Option<&'a str>,
}

impl Source<'_> {
    fn assemble(&mut self) -> Result<Robot, ModelError> {
        let tip = self.tip.map(|name| self.frame(name)).transpose()?;
        let arm_joints = match self.description {
            None => self.arm_joints(tip)?,
            Some((file, xrdf)) => named_joints(&self.urdf.chain, file, &xrdf.joint_names)?,
        };
        if self.urdf.skipped_meshes > 0 && self.description.is_none() {
            self.urdf.warnings.push(format!(
                "{0}: collision meshes ({1}) take no part in contact, and only the tool keeps away \
                 from obstacles; `robocell spheres {0} > my.xrdf` makes spheres of them, for `--xrdf`",
                self.file, self.urdf.skipped_meshes
            ));
        }
        let chain = &self.urdf.chain;
        let joints = crate::robots::load::plain_specs(&self.urdf);
        let home: Vec<f64> = joints.iter().map(|spec| spec.home).collect();
        let mut robot = Robot {
            rmpflow: Robot::general_tuning(chain, &arm_joints)?,
            name: self.urdf.name.clone(),
            default_joint_positions: arm_joints.iter().map(|&joint| home[joint]).collect(),
            fixed_joint_positions: home,
            tcp_frame: tool_frame(chain, arm_joints.last().copied()),
            chain: chain.clone(),
            joints,
            links: self.urdf.links.clone(),
            arm_joints,
            warnings: std::mem::take(&mut self.urdf.warnings),
            velocity_envelope: Vec::new(),
            gripper: None,
            suction: None,
            spheres: Vec::new(),
            self_spheres: Vec::new(),
            self_ignore: Vec::new(),
        };
        if let Some((file, xrdf)) = self.description {
            robot.take_xrdf(file, xrdf)?;
            robot.take_tool(file, xrdf)?;
            robot.take_self_collision(file, xrdf)?;
            // A user's arm starts in its default posture: there is no other file with a home
            // position.
            for (spec, position) in robot.joints.iter_mut().zip(&robot.fixed_joint_positions) {
                spec.home = *position;
            }
        }
        // An option of the command line wins over the tool frame of the file.
        if let Some(tip) = tip {
            robot.tcp_frame = tip;
        }
        // After the tip is known: the home pose is judged by how the tip can move.
        if self.description.is_none() {
            robot.bend_home();
        }
        robot.place_copies();
        robot.strengthen(self.file, &self.urdf.limits);
        Ok(robot)
    }

    fn frame(&self, name: &str) -> Result<usize, ModelError> {
        let chain = &self.urdf.chain;
        chain.frame_index(name).ok_or_else(|| {
            let names: Vec<&str> = chain.frames().iter().map(|f| f.name.as_str()).collect();
            let allowed = format!(
                "no such link in the URDF; {}",
                suggest::advice(name, &names)
            );
            ModelError::value(Location::file(self.file), "tip", name, allowed)
        })
    }

    /// The joints from the base to the tip. Without a tip, to the end of the tree or the start
    /// of a hand; for a robot with several arms or legs, to the first of the longest.
    fn arm_joints(&mut self, tip: Option<usize>) -> Result<Vec<usize>, ModelError> {
        let trunk = trunk(&self.urdf.chain);
        let tips = self.urdf.tips();
        let longest = tips.first().map_or(0, |(_, joints)| *joints);
        let mut joints = match (tip, tips.first()) {
            (Some(tip), _) => self.urdf.joints_to(tip),
            (None, Some((tip, _))) if trunk.len() < LEAST_TRUNK && trunk.len() < longest => {
                let joints = self.urdf.joints_to(*tip);
                self.urdf.warnings.push(format!(
                    "{}: the tree branches; the arm that ends at '{}' is controlled, and \
                     `--tip LINK` names another one: {}",
                    self.file,
                    self.name_of(*tip),
                    self.candidates(&tips)
                ));
                joints
            }
            _ => trunk,
        };
        if joints.is_empty() {
            let found = match tip {
                Some(tip) => format!("0 before '{}'", self.name_of(tip)),
                None => "0".to_owned(),
            };
            let allowed = match longest {
                0 => "no joint of this file moves, so there is nothing to control".to_owned(),
                _ => format!(
                    "`--tip LINK` names where the arm ends, with the number of joints: {}",
                    self.candidates(&tips)
                ),
            };
            let key = "number of joints of the arm";
            return Err(ModelError::value(
                Location::file(self.file),
                key,
                found,
                allowed,
            ));
        }
        let most = ipc_types::MAX_JOINTS;
        let all = self.moving(&joints);
        // The joints nearest to the tip stay: they turn the tool, the first ones move the whole
        // robot.
        while self.moving(&joints) > most {
            joints.remove(0);
        }
        if all > most {
            self.urdf.warnings.push(format!(
                "{}: {all} joints to the tip; the last {} are controlled, the others hold",
                self.file,
                joints.len()
            ));
        }
        Ok(joints)
    }

    /// Number of `joints`, and of those that follow one of them.
    fn moving(&self, joints: &[usize]) -> usize {
        let all = self.urdf.chain.joints().iter();
        let follows = |joint: &&rmp::Joint| joint.mimic.is_some_and(|m| joints.contains(&m.joint));
        joints.len() + all.filter(follows).count()
    }

    fn name_of(&self, frame: usize) -> &str {
        let frames = self.urdf.chain.frames();
        frames.get(frame).map_or("", |frame| &frame.name)
    }

    fn candidates(&self, tips: &[(usize, usize)]) -> String {
        let moving = tips.iter().filter(|(_, joints)| *joints > 0);
        let names = moving.map(|(frame, joints)| format!("{} ({joints})", self.name_of(*frame)));
        names.take(MOST_CANDIDATES).collect::<Vec<_>>().join(", ")
    }
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
    let key = "cspace.joint_names";
    let index = |name: &String| {
        let found = chain.joint_index(name).ok_or_else(|| {
            let allowed = format!(
                "no such moving joint in the URDF; {}",
                suggest::advice(name, &known)
            );
            ModelError::value(Location::file(file), key, name, allowed)
        })?;
        mimic::controllable(chain, found, Location::file(file), key)
    };
    names.iter().map(index).collect()
}

/// Joints from the base to the end or the first branch of the tree: a hand with several fingers
/// starts at a branch.
fn trunk(chain: &rmp::Chain) -> Vec<usize> {
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
    }
    urdf::independent(chain, &arm)
}

/// A frame on the last joint with a usual name, or else the last frame on it.
fn tool_frame(chain: &rmp::Chain, joint: Option<usize>) -> usize {
    let on_joint = |index: &usize| chain.frames()[*index].joint == joint;
    let usual = ["tcp", "tool0", "ee_link", "tool", "flange"];
    let named = usual
        .iter()
        .find_map(|name| chain.frame_index(name).filter(on_joint));
    let last = (0..chain.frames().len()).rfind(on_joint);
    named.or(last).unwrap_or(0)
}
