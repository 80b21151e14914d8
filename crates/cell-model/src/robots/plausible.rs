//! What a URDF alone lacks to be moved: a home pose from which every direction is open, and
//! drives that carry the arm.

use nalgebra::{Matrix3, Vector3};

use crate::random::Random;
use crate::robots::dynamics::Dynamics;
use crate::robots::load::stiffness;
use crate::robots::robot::Robot;

/// Poses that are tried.
const TRIALS: usize = 64;
/// How far from zero a joint of the home pose may be (rad or m).
const BEND: f64 = 0.6;
/// Part of a joint's range that the home pose keeps from either limit.
const MARGIN: f64 = 0.05;
/// Step of the difference quotients (rad or m).
const STEP: f64 = 1.0e-6;
/// Downwards (m/s²).
const GRAVITY: f64 = -9.81;
/// A drive has to hold the arm so often at least; one that cannot is given `STRONG` times
/// what is needed.
const ENOUGH: f64 = 1.2;
const STRONG: f64 = 3.0;

impl Robot {
    /// Bends the home pose of an arm that has no default one: at zero many are stretched, and
    /// cannot move towards their base. Of random poses near zero it takes the one where the
    /// tool moves best in its worst direction.
    pub(crate) fn bend_home(&mut self) {
        if self.arm_joints.len() < 3 {
            return;
        }
        let mut random = Random::new(0);
        let mut best = (self.least_gain(&self.home()), self.home());
        for _ in 0..TRIALS {
            let trial = self.near_zero(&mut random);
            let gain = self.least_gain(&trial);
            if gain > best.0 {
                best = (gain, trial);
            }
        }
        let (_, home) = best;
        for (&joint, position) in self.arm_joints.iter().zip(&home) {
            self.joints[joint].home = *position;
            self.fixed_joint_positions[joint] = *position;
        }
        self.default_joint_positions = home;
    }

    fn near_zero(&self, random: &mut Random) -> Vec<f64> {
        let within = |spec: &crate::JointSpec, offset: f64| {
            let margin = MARGIN * (spec.upper - spec.lower);
            let (low, high) = (spec.lower + margin, spec.upper - margin);
            (0.0_f64.clamp(low, high) + offset).clamp(low, high)
        };
        self.arm_specs()
            .map(|spec| within(spec, random.around_zero(BEND)))
            .collect()
    }

    /// Least singular value of the Jacobian of the tool's position (m/rad).
    fn least_gain(&self, arm: &[f64]) -> f64 {
        let tool = |arm: &[f64]| {
            let pose = self.frame_pose(self.tcp_frame, &self.with_arm_positions(arm));
            pose.map_or_else(Vector3::zeros, |pose| pose.translation.vector)
        };
        let at = tool(arm);
        let mut square = Matrix3::zeros();
        let mut moved = arm.to_vec();
        for joint in 0..arm.len() {
            moved[joint] += STEP;
            let column = (tool(&moved) - at) / STEP;
            square += column * column.transpose();
            moved[joint] = arm[joint];
        }
        square.symmetric_eigenvalues().min().max(0.0).sqrt()
    }

    /// Replaces efforts that do not carry the arm's own weight, and says so.
    pub(crate) fn strengthen(&mut self, file: &str) {
        let needed = self.holding_efforts();
        for (slot, needed) in needed.into_iter().enumerate() {
            let joint = self.arm_joints[slot];
            let stated = self.joints[joint].effort;
            if stated >= ENOUGH * needed {
                continue;
            }
            let effort = STRONG * needed;
            self.warnings.push(format!(
                "{file}: joint '{}': an effort of {stated:.1} does not carry the arm, which needs \
                 {needed:.1}; {effort:.1} is taken",
                self.chain.joints()[joint].name
            ));
            let spec = &mut self.joints[joint];
            spec.effort = effort;
            spec.stiffness = stiffness(effort);
            spec.damping = 0.1 * spec.stiffness;
        }
    }

    /// Largest effort of each controlled joint against gravity over the poses tried (N·m or
    /// N).
    fn holding_efforts(&self) -> Vec<f64> {
        let mut dynamics = Dynamics::new(self);
        let mut most = vec![0.0; self.arm_joints.len()];
        let mut random = Random::new(1);
        for _ in 0..TRIALS {
            let positions: Vec<f64> = self
                .arm_specs()
                .map(|spec| {
                    let (low, high) = (spec.lower, spec.upper);
                    0.5 * (low + high) + random.around_zero(0.5 * (high - low))
                })
                .collect();
            let down = Vector3::new(0.0, 0.0, GRAVITY);
            let efforts = dynamics.inverse_dynamics(&positions, &[], &[], &down);
            for (most, effort) in most.iter_mut().zip(efforts) {
                *most = f64::max(*most, effort.abs());
            }
        }
        most
    }
}
