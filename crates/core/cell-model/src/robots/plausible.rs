//! Data that a URDF lacks for motion: a home pose from which every direction is open, and
//! drives that carry the arm.

use nalgebra::{Matrix3, Vector3};

use crate::random::Random;
use crate::robots::dynamics::{Dynamics, GRAVITY};
use crate::robots::load::stiffness;
use crate::robots::robot::Robot;
use crate::robots::urdf_limits::UrdfLimits;

/// Number of poses that are tried.
const TRIALS: usize = 64;
/// Largest distance from zero of a joint in the home pose (rad or m).
const BEND: f64 = 0.6;
/// Share of a joint's range that the home pose keeps from either limit.
const MARGIN: f64 = 0.05;
/// Step of the difference quotients (rad or m).
const STEP: f64 = 1.0e-6;
/// A direction in which the tool moves by less than this is not open (m/rad or m/m).
const LEAST_GAIN: f64 = 1.0e-4;
/// Smallest factor by which a drive has to hold the arm; one that does not gets [`STRONG`]
/// times the effort that is needed.
const ENOUGH: f64 = 1.2;
const STRONG: f64 = 3.0;

/// Stiffness of a drive per kg·m² (or kg) that it moves (1/s²). Its damping is a tenth of that,
/// so that the load settles without swinging: 0.1 sqrt(400) / 2 = 1.
const STIFFNESS_OF_INERTIA: f64 = 400.0;

/// The load of one joint.
#[derive(Clone, Copy, Default)]
struct Load {
    /// Effort against gravity alone, and while the joint accelerates at its limit (N·m or N).
    holding: f64,
    moving: f64,
    /// Inertia (kg·m² or kg).
    inertia: f64,
}

impl Robot {
    /// Bends the home pose of an arm that has no default one: at zero many are stretched, and
    /// cannot move towards their base. Of random poses near zero it takes the one where the
    /// tool moves best in its worst direction, of those that are open to it at all.
    pub(crate) fn bend_home(&mut self) {
        // A tool that can only move along a line gets no better by bending.
        let open = self.open_directions();
        if open < 2 {
            return;
        }
        let worst = |arm: &[f64]| self.gains(arm)[3 - open];
        // A fixed seed: every process of a cell loads the file, and needs the same home pose.
        let mut random = Random::new(0);
        // The unbent pose is a candidate, too: it stays where no random one is better.
        let mut best = (worst(&self.home()), self.home());
        for _ in 0..TRIALS {
            let trial = self.near_zero(&mut random);
            let gain = worst(&trial);
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

    /// Number of directions in which the tool can move: 1 along a line, 2 on a surface, 3 in
    /// space.
    pub(super) fn open_directions(&self) -> usize {
        let mut random = Random::new(4);
        let mut most = [0.0_f64; 3];
        for _ in 0..TRIALS {
            let gains = self.gains(&self.anywhere(&mut random));
            most = std::array::from_fn(|at| most[at].max(gains[at]));
        }
        most.iter().filter(|gain| **gain >= LEAST_GAIN).count()
    }

    /// Singular values of the Jacobian of the tool's position, smallest first (m/rad).
    fn gains(&self, arm: &[f64]) -> [f64; 3] {
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
        let mut gains: [f64; 3] = square.symmetric_eigenvalues().into();
        gains.sort_by(f64::total_cmp);
        gains.map(|gain| gain.max(0.0).sqrt())
    }

    /// Replaces efforts that do not carry the arm's own weight, with a warning. If the file has
    /// no effort (`limits`, by joint of the chain), the drive can accelerate the arm, too. The
    /// stiffness of a drive is raised to what its load needs.
    pub(crate) fn strengthen(&mut self, file: &str, limits: &[UrdfLimits]) {
        for (slot, load) in self.loads().into_iter().enumerate() {
            let joint = self.arm_joints[slot];
            let spec = &mut self.joints[joint];
            let stated = spec.effort;
            let is_stated = limits.get(joint).is_some_and(|limit| limit.effort > 0.0);
            // A stated effort is believed for motion: an arm may be slow, but it has to carry
            // itself.
            let moving = if is_stated { 0.0 } else { load.moving };
            if stated < ENOUGH * load.holding || stated < ENOUGH * moving {
                let effort = (STRONG * load.holding).max(ENOUGH * moving);
                let needed = load.holding.max(moving);
                spec.effort = effort;
                spec.stiffness = stiffness(effort);
                let verb = if is_stated { "carry" } else { "move" };
                self.warnings.push(format!(
                    "{file}: joint '{}': an effort of {stated:.1} does not {verb} the arm, which \
                     needs {needed:.1}; {effort:.1} is taken",
                    self.chain.joints()[joint].name
                ));
            }
            let least = STIFFNESS_OF_INERTIA * load.inertia;
            spec.stiffness = spec.stiffness.max(least);
            spec.damping = 0.1 * spec.stiffness;
        }
    }

    /// The load of each controlled joint, the largest over the poses tried.
    fn loads(&self) -> Vec<Load> {
        let mut dynamics = Dynamics::new(self);
        let mut loads = vec![Load::default(); self.arm_joints.len()];
        let mut random = Random::new(1);
        for _ in 0..TRIALS {
            let positions = self.anywhere(&mut random);
            let down = Vector3::from(GRAVITY);
            let weight = dynamics
                .inverse_dynamics(&positions, &[], &[], &down)
                .to_vec();
            let specs = self.arm_specs().zip(&weight).zip(&mut loads);
            // A unit acceleration of one joint: its effort without gravity is the inertia.
            for (joint, ((spec, weight), load)) in specs.enumerate() {
                let mut one = vec![0.0; positions.len()];
                one[joint] = 1.0;
                let efforts = dynamics.inverse_dynamics(&positions, &[], &one, &down);
                let inertia = (efforts[joint] - weight).abs();
                load.holding = load.holding.max(weight.abs());
                load.inertia = load.inertia.max(inertia);
                load.moving = load.moving.max(weight.abs() + inertia * spec.acceleration);
            }
        }
        loads
    }
}
