//! The data that motion policies need beyond kinematics: default posture, collision spheres and
//! tuning.

use std::collections::BTreeMap;

use rmp::{RmpFlow, RmpFlowParameters, RmpFlowSetup, SelfCollisionSetup, SetupError};

use crate::data;
use crate::error::{Location, ModelError};
use crate::robots::rmpflow;
use crate::robots::robot::Robot;
use crate::robots::xrdf::Xrdf;
use crate::suggest;

/// The tuning of a robot without one: NVIDIA's published one of the Panda, which is gentle,
/// without the Panda's own body.
const GENERAL_TUNING: &str = include_str!("general_rmpflow.yaml");
/// Distance to joint limits without a tuning, for a joint with a range of at least [`WIDE`]
/// (rad or m). A narrower one keeps the same share of its range.
const BUFFER: f64 = 0.01;
const WIDE: f64 = 2.0;

impl Robot {
    /// Motion policies for this robot with up to `obstacle_capacity` obstacles, at rest in its
    /// default configuration, without a target frame.
    ///
    /// # Errors
    /// Returns [`SetupError`] if spheres or tuning do not fit the robot.
    pub fn motion_policies(&self, obstacle_capacity: usize) -> Result<RmpFlow, SetupError> {
        let names = self.arm_joint_names();
        let joints = self.chain.joints().iter().map(|joint| joint.name.clone());
        let mut defaults: BTreeMap<String, f64> = joints
            .zip(self.fixed_joint_positions.iter().copied())
            .collect();
        defaults.extend(
            names
                .iter()
                .cloned()
                .zip(self.default_joint_positions.iter().copied()),
        );
        RmpFlow::new(&RmpFlowSetup {
            chain: &self.chain,
            joint_names: &names,
            default_positions: &defaults,
            spheres: &self.spheres,
            self_collision: SelfCollisionSetup {
                spheres: &self.self_spheres,
                ignore: &self.self_ignore,
            },
            parameters: &self.rmpflow,
            obstacle_capacity,
        })
    }

    /// Takes default positions, spheres and, by joint name, limits from an XRDF called `file`.
    /// The controlled joints and the tool stay the same.
    pub(crate) fn take_xrdf(&mut self, file: &str, xrdf: &Xrdf) -> Result<(), ModelError> {
        for (name, &position) in &xrdf.default_joint_positions {
            let joint = self.known_joint(file, name)?;
            self.fixed_joint_positions[joint] = position;
        }
        self.default_joint_positions = self
            .arm_joints
            .iter()
            .map(|&joint| self.fixed_joint_positions[joint])
            .collect();
        let limits = xrdf.acceleration_limits.iter().zip(&xrdf.jerk_limits);
        for (name, (&acceleration, &jerk)) in xrdf.joint_names.iter().zip(limits) {
            let joint = self.known_joint(file, name)?;
            self.joints[joint].acceleration = acceleration;
            self.joints[joint].jerk = jerk;
        }
        for sphere in &xrdf.world_spheres {
            self.known_frame(file, &sphere.frame)?;
        }
        self.spheres.clone_from(&xrdf.world_spheres);
        Ok(())
    }

    /// Sets the spheres that keep the arm away from itself: those of the XRDF, or, without any,
    /// the spheres against the world.
    pub(crate) fn take_self_collision(
        &mut self,
        file: &str,
        xrdf: &Xrdf,
    ) -> Result<(), ModelError> {
        for sphere in &xrdf.self_spheres {
            self.known_frame(file, &sphere.frame)?;
        }
        if xrdf.self_spheres.is_empty() {
            // The published spheres of neighbouring links overlap; such pairs would push for
            // ever.
            self.self_ignore = self.pairs_that_may_touch(&self.spheres);
            self.self_spheres.clone_from(&self.spheres);
        } else {
            self.self_ignore.clone_from(&xrdf.self_ignore);
            self.self_spheres.clone_from(&xrdf.self_spheres);
        }
        Ok(())
    }

    /// Takes the tuning of the file called `file`, which has to fit the robot.
    pub(crate) fn take_tuning(&mut self, file: &str, text: &str) -> Result<(), ModelError> {
        let tuning = rmpflow::parse(file, text)?;
        let (found, joints) = (tuning.joint_limit_buffers.len(), self.arm_joints.len());
        if found != joints {
            let allowed = format!("one for each of the {joints} controlled joints is needed");
            let value = format!("{found} numbers");
            return Err(ModelError::value(
                Location::file(file),
                "joint_limit_buffers",
                value,
                allowed,
            ));
        }
        for controller in &tuning.body_collision_controllers {
            self.known_frame(file, &controller.name)?;
        }
        self.rmpflow = tuning;
        Ok(())
    }

    /// The general tuning for the controlled joints `arm` of `chain`.
    pub(crate) fn general_tuning(
        chain: &rmp::Chain,
        arm: &[usize],
    ) -> Result<RmpFlowParameters, ModelError> {
        let mut tuning = rmpflow::parse("the general tuning", GENERAL_TUNING)?;
        let ranges = arm.iter().filter_map(|&joint| chain.joints().get(joint));
        let ranges = ranges.map(|joint| joint.upper - joint.lower);
        tuning.joint_limit_buffers = ranges
            .map(|range| BUFFER * (range / WIDE).min(1.0))
            .collect();
        // Bodies of the Panda: another robot has other links.
        tuning.body_capsules.clear();
        tuning.body_collision_controllers.clear();
        Ok(tuning)
    }

    /// Makes the first tool frame of the XRDF the tool centre point.
    pub(crate) fn take_tool(&mut self, file: &str, xrdf: &Xrdf) -> Result<(), ModelError> {
        if let Some(name) = xrdf.tool_frames.first() {
            self.tcp_frame = self.known_frame(file, name)?;
        }
        Ok(())
    }

    fn known_joint(&self, file: &str, name: &str) -> Result<usize, ModelError> {
        let names: Vec<&str> = self
            .chain
            .joints()
            .iter()
            .map(|joint| joint.name.as_str())
            .collect();
        self.chain.joint_index(name).ok_or_else(|| {
            let allowed = format!(
                "no such moving joint in the URDF; {}",
                suggest::advice(name, &names)
            );
            ModelError::value(Location::file(file), "joint", name, allowed)
        })
    }

    fn known_frame(&self, file: &str, name: &str) -> Result<usize, ModelError> {
        let names: Vec<&str> = self
            .chain
            .frames()
            .iter()
            .map(|frame| frame.name.as_str())
            .collect();
        self.chain.frame_index(name).ok_or_else(|| {
            let allowed = format!(
                "no such link in the URDF; {}",
                suggest::advice(name, &names)
            );
            ModelError::value(Location::file(file), "frame", name, allowed)
        })
    }
}

/// Reads a file of the user; returns its name and text.
pub(crate) fn read(path: &std::path::Path) -> Result<(String, String), ModelError> {
    Ok((path.display().to_string(), data::read_text(path)?))
}
