//! Creates a [`Robot`] from its files.

use nalgebra::Vector3;

use crate::data::Data;
use crate::error::{Location, ModelError};
use crate::robots::file::{self, ArmTable, GripperTable, RobotFile, SuctionTable};
use crate::robots::mimic;
use crate::robots::movable::TipOption;
use crate::robots::robot::{JointSpec, ParallelGripper, Robot, SuctionGripper, VelocityEnvelope};
use crate::robots::urdf::{self, UrdfRobot};
use crate::robots::xrdf;
use crate::{suggest, toml_text};

impl Robot {
    /// Loads a robot of the data directory, for example `panda`.
    ///
    /// # Errors
    /// Returns [`ModelError`] for a file that is missing or wrong.
    pub fn load(data: &Data, name: &str) -> Result<Self, ModelError> {
        let dir = format!("robots/{name}");
        let file = format!("{dir}/robot.toml");
        let text = data.read(&file)?;
        let file = data.name_of(&file);
        let table = file::parse(&file, &text)?;
        let part = |name: &str| -> Result<_, ModelError> {
            let path = format!("{dir}/{name}");
            Ok((data.name_of(&path), data.read(&path)?))
        };
        let (urdf_file, urdf) = part(&table.urdf)?;
        let urdf = urdf::parse(&urdf_file, &urdf)?;
        let mut robot = Loader {
            file: &file,
            text: &text,
            table: &table,
            urdf,
        }
        .finish()?;
        // After the chain, to whose joints and links its names refer.
        let (xrdf_file, text) = part(&table.xrdf)?;
        let xrdf = xrdf::parse(&xrdf_file, &text)?;
        robot.take_xrdf(&xrdf_file, &xrdf)?;
        robot.take_self_collision(&xrdf_file, &xrdf)?;
        let (tuning_file, text) = part(&table.rmpflow)?;
        robot.take_tuning(&tuning_file, &text)?;
        robot.warn_if_tip_stays(&file, TipOption::Key);
        Ok(robot)
    }
}

struct Loader<'a> {
    file: &'a str,
    text: &'a str,
    table: &'a RobotFile,
    urdf: UrdfRobot,
}

impl Loader<'_> {
    fn finish(self) -> Result<Robot, ModelError> {
        let arm_joints = self.arm_joints()?;
        let mut joints = plain_specs(&self.urdf);
        self.apply_arm(&mut joints, &arm_joints);
        let gripper = match &self.table.gripper {
            Some(table) => Some(self.gripper(table, &mut joints)?),
            None => None,
        };
        let tcp_frame = self.frame("tcp_frame", &self.table.tcp_frame)?;
        // After `gripper`, which sets the home of the fingers.
        let home: Vec<f64> = joints.iter().map(|spec| spec.home).collect();
        Ok(Robot {
            rmpflow: Robot::general_tuning(&self.urdf.chain, &arm_joints)?,
            name: self.table.name.clone(),
            default_joint_positions: arm_joints
                .iter()
                .filter_map(|&j| home.get(j).copied())
                .collect(),
            fixed_joint_positions: home,
            chain: self.urdf.chain,
            joints,
            links: self.urdf.links,
            arm_joints,
            velocity_envelope: envelope(&self.table.arm),
            gripper,
            suction: self.table.suction.as_ref().map(suction),
            tcp_frame,
            spheres: Vec::new(),
            self_spheres: Vec::new(),
            self_ignore: Vec::new(),
            warnings: self.urdf.warnings,
        })
    }

    fn place(&self, key: &str) -> Location {
        Location::line(self.file, toml_text::line_of(self.text, key))
    }

    fn joint(&self, key: &str, name: &str) -> Result<usize, ModelError> {
        let names: Vec<&str> = self
            .urdf
            .chain
            .joints()
            .iter()
            .map(|joint| joint.name.as_str())
            .collect();
        self.urdf.chain.joint_index(name).ok_or_else(|| {
            let allowed = format!(
                "no such moving joint in {}; {}",
                self.table.urdf,
                suggest::advice(name, &names)
            );
            ModelError::value(self.place(key), key, name, allowed)
        })
    }

    fn frame(&self, key: &str, name: &str) -> Result<usize, ModelError> {
        let names: Vec<&str> = self
            .urdf
            .chain
            .frames()
            .iter()
            .map(|frame| frame.name.as_str())
            .collect();
        self.urdf.chain.frame_index(name).ok_or_else(|| {
            let allowed = format!(
                "no such link in {}; {}",
                self.table.urdf,
                suggest::advice(name, &names)
            );
            ModelError::value(self.place(key), key, name, allowed)
        })
    }

    fn arm_joints(&self) -> Result<Vec<usize>, ModelError> {
        let names = self.table.arm.joints.iter().enumerate();
        let joints = names
            .map(|(index, name)| {
                let key = format!("arm.joints.{index}");
                let joint = self.joint(&key, name)?;
                mimic::controllable(&self.urdf.chain, joint, self.place(&key), &key)
            })
            .collect::<Result<Vec<_>, _>>()?;
        for (index, (&joint, home)) in joints
            .iter()
            .zip(&self.table.arm.home_joint_positions)
            .enumerate()
        {
            let (lower, upper) = (
                self.urdf.chain.joints()[joint].lower,
                self.urdf.chain.joints()[joint].upper,
            );
            // Checked here and not with the ranges: the limits are those of the URDF.
            if !(lower..=upper).contains(home) {
                let key = format!("arm.home_joint_positions.{index}");
                return Err(ModelError::value(
                    self.place(&key),
                    key,
                    home,
                    format!("{lower} to {upper} is allowed"),
                ));
            }
        }
        Ok(joints)
    }

    /// Copies the lists of the file, which have one entry for each controlled joint (checked).
    fn apply_arm(&self, specs: &mut [JointSpec], arm_joints: &[usize]) {
        let arm = &self.table.arm;
        for (index, &joint) in arm_joints.iter().enumerate() {
            let spec = &mut specs[joint];
            spec.home = arm.home_joint_positions[index];
            spec.acceleration = arm.acceleration_limits[index];
            spec.jerk = arm.jerk_limits[index];
            spec.stiffness = arm.drive.stiffness[index];
            spec.damping = arm.drive.damping[index];
            spec.armature = arm.drive.armature[index];
            spec.joint_damping = arm.drive.joint_damping[index];
        }
    }

    fn gripper(
        &self,
        table: &GripperTable,
        specs: &mut [JointSpec],
    ) -> Result<ParallelGripper, ModelError> {
        let [left, right] = &table.finger_joints;
        let finger_joints = [
            self.joint("gripper.finger_joints.0", left)?,
            self.joint("gripper.finger_joints.1", right)?,
        ];
        for joint in finger_joints {
            let spec = &mut specs[joint];
            spec.stiffness = table.stiffness_n_per_m;
            spec.damping = table.damping_n_s_per_m;
            spec.armature = table.armature_kg;
            spec.joint_damping = table.joint_damping_n_s_per_m;
            spec.velocity = table.speed_m_s;
            spec.effort = table.max_force_n;
            // A run starts with an open hand; each finger has half of the width.
            spec.home = 0.5 * table.max_width_m;
        }
        Ok(ParallelGripper {
            finger_joints,
            max_width: table.max_width_m,
            default_force: table.default_force_n,
            max_force: table.max_force_n,
            speed: table.speed_m_s,
            pad_friction: table.pad_friction,
        })
    }
}

fn suction(table: &SuctionTable) -> SuctionGripper {
    SuctionGripper {
        axis: Vector3::from(table.axis).normalize(),
        grip_distance: table.grip_distance_m,
        force_limit: table.force_limit_n,
        torque_limit: table.torque_limit_n_m,
        cup_radius: table.cup_radius_m,
    }
}

/// Stiffness of a drive with that effort (N·m or N): see [`plain_specs`].
pub(crate) fn stiffness(effort: f64) -> f64 {
    (50.0 * effort).clamp(500.0, 10_000.0)
}

/// Velocity of a joint without a limit: revolute (rad/s) and prismatic (m/s).
pub(crate) const TURN_VELOCITY: f64 = 1.0;
pub(crate) const SLIDE_VELOCITY: f64 = 0.1;
/// Effort of a joint without a limit (N·m or N).
pub(crate) const EFFORT: f64 = 100.0;

/// Default data of joints, in the units of [`JointSpec`]. Limits are those of the URDF, or, if
/// it has none, 1 rad/s (0.1 m/s), 100 N·m, 10 rad/s² and 500 rad/s³: a careful industrial arm.
/// The stiffness of a drive is 50 times its effort per radian, from 500 to 10,000, and its
/// damping a tenth of that per rad/s, the ratio of the published Panda gains.
pub(crate) fn plain_specs(urdf: &UrdfRobot) -> Vec<JointSpec> {
    let joints = urdf.chain.joints().iter().zip(&urdf.limits);
    joints
        .map(|(joint, limits)| {
            let revolute = joint.kind == rmp::JointKind::Revolute;
            let or = |value: f64, default: f64| if value > 0.0 { value } else { default };
            let effort = or(limits.effort, EFFORT);
            let stiffness = stiffness(effort);
            JointSpec {
                lower: joint.lower,
                upper: joint.upper,
                velocity: or(
                    limits.velocity,
                    if revolute {
                        TURN_VELOCITY
                    } else {
                        SLIDE_VELOCITY
                    },
                ),
                acceleration: limits.acceleration.unwrap_or(10.0),
                jerk: limits.jerk.unwrap_or(500.0),
                effort,
                stiffness,
                damping: 0.1 * stiffness,
                armature: 0.1,
                joint_damping: 1.0,
                // Zero is outside of the limits of some joints, such as the elbow of a Panda.
                home: 0.0_f64.clamp(joint.lower, joint.upper),
            }
        })
        .collect()
}

/// The velocity limits near position limits.
fn envelope(arm: &ArmTable) -> Vec<VelocityEnvelope> {
    let joints = arm.velocity_offsets.iter().zip(&arm.deceleration_limits);
    joints
        .map(|(&offset, &deceleration)| VelocityEnvelope {
            offset,
            deceleration,
        })
        .collect()
}
