//! A robot as every process needs it: kinematics, masses, limits, drives, hand.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use rmp::{Chain, CollisionSphere, JointKind, JointLimits, RmpFlowParameters};

use crate::shape::Link;

/// Limits and drive of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSpec {
    /// Lower position limit (rad or m).
    pub lower: f64,
    /// Upper position limit (rad or m).
    pub upper: f64,
    /// Velocity limit (rad/s or m/s).
    pub velocity: f64,
    /// Acceleration limit (rad/s² or m/s²).
    pub acceleration: f64,
    /// Jerk limit (rad/s³ or m/s³).
    pub jerk: f64,
    /// Effort limit of the drive (N·m or N).
    pub effort: f64,
    /// Stiffness of the drive (N·m/rad or N/m).
    pub stiffness: f64,
    /// Damping of the drive (N·m·s/rad or N·s/m).
    pub damping: f64,
    /// Inertia of the rotor, seen at the joint (kg·m² or kg).
    pub armature: f64,
    /// Friction of the gear, proportional to velocity (N·m·s/rad or N·s/m).
    pub joint_damping: f64,
    /// Position at the start of a run (rad or m).
    pub home: f64,
}

/// A hand with two fingers that move towards each other.
#[derive(Clone, Debug, PartialEq)]
pub struct ParallelGripper {
    /// Indices of the finger joints in the chain. Each finger position is half
    /// the width.
    pub finger_joints: [usize; 2],
    /// Width of the open hand (m).
    pub max_width: f64,
    /// Force per finger if a command has none (N).
    pub default_force: f64,
    /// Largest force per finger (N).
    pub max_force: f64,
    /// Speed of one finger (m/s).
    pub speed: f64,
    /// Friction coefficient of the pads.
    pub pad_friction: f64,
}

/// A suction cup at the tool centre point.
#[derive(Clone, Debug, PartialEq)]
pub struct SuctionGripper {
    /// Direction out of the cup, in the TCP frame, of length 1.
    pub axis: Vector3<f64>,
    /// Largest distance before the cup at which an object can be gripped (m).
    pub grip_distance: f64,
    /// Force at which the grip breaks (N).
    pub force_limit: f64,
    /// Torque at which the grip breaks (N·m).
    pub torque_limit: f64,
    /// Radius of the cup (m).
    pub cup_radius: f64,
}

/// The velocity limit of a joint near its position limits: at a distance `d` (rad) before one, the
/// joint may move towards it at `sqrt(2 deceleration d) - offset` at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityEnvelope {
    /// rad/s.
    pub offset: f64,
    /// rad/s².
    pub deceleration: f64,
}

/// A robot arm with its tool.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name for people.
    pub name: String,
    /// All actuated joints, parents first, and all frames.
    pub chain: Chain,
    /// Data of the joints, by joint of the chain.
    pub joints: Vec<JointSpec>,
    /// The base, then the child link of every joint of the chain.
    pub links: Vec<Link>,
    /// Controlled joints in the order of commands, as indices of the chain.
    pub arm_joints: Vec<usize>,
    /// Velocity limits near position limits, by controlled joint; empty where the maker has none.
    // Programs over the network are judged by them. Motion policies brake before position limits
    // on their own.
    pub velocity_envelope: Vec<VelocityEnvelope>,
    /// The hand. A robot has a hand or suction, not both.
    pub gripper: Option<ParallelGripper>,
    /// The suction cup.
    pub suction: Option<SuctionGripper>,
    /// Index of the tool centre point's frame in the chain.
    pub tcp_frame: usize,
    /// Collision spheres against the world.
    pub spheres: Vec<CollisionSphere>,
    /// Spheres against the robot itself; with none the arm does not avoid itself.
    pub self_spheres: Vec<CollisionSphere>,
    /// Pairs of frames with such spheres that may touch.
    pub self_ignore: Vec<(String, String)>,
    /// Default configuration of the controlled joints for motion policies: the
    /// posture to lean to (rad or m).
    pub default_joint_positions: Vec<f64>,
    /// Positions that motion policies use for joints that they do not control, by joint of the
    /// chain (rad or m).
    pub fixed_joint_positions: Vec<f64>,
    /// Tuning of the motion policies.
    pub rmpflow: RmpFlowParameters,
    /// Corrected faults of the robot's files, and choices that the files left open, for people.
    pub warnings: Vec<String>,
}

impl Robot {
    /// Names of the controlled joints in order.
    pub fn arm_joint_names(&self) -> Vec<String> {
        let joints = self.chain.joints();
        self.arm_joints
            .iter()
            .filter_map(|&index| joints.get(index))
            .map(|joint| joint.name.clone())
            .collect()
    }

    /// Units of the positions of the controlled joints in order: `rad` or `m`.
    pub fn arm_units(&self) -> Vec<&'static str> {
        let joints = self.chain.joints();
        let arm = self.arm_joints.iter();
        arm.filter_map(|&index| joints.get(index))
            .map(|joint| match joint.kind {
                JointKind::Revolute => "rad",
                JointKind::Prismatic => "m",
            })
            .collect()
    }

    /// Specifications of the controlled joints in order.
    pub fn arm_specs(&self) -> impl Iterator<Item = &JointSpec> {
        self.arm_joints
            .iter()
            .filter_map(|&index| self.joints.get(index))
    }

    /// Home of the controlled joints (rad or m).
    pub fn home(&self) -> Vec<f64> {
        self.arm_specs().map(|spec| spec.home).collect()
    }

    /// Motion limits of the controlled joints.
    pub fn limits(&self) -> JointLimits {
        let of = |value: fn(&JointSpec) -> f64| self.arm_specs().map(value).collect();
        JointLimits {
            lower: of(|spec| spec.lower),
            upper: of(|spec| spec.upper),
            velocity: of(|spec| spec.velocity),
            acceleration: of(|spec| spec.acceleration),
            jerk: of(|spec| spec.jerk),
        }
    }

    /// Name of the tool centre point's frame.
    pub fn tcp_frame_name(&self) -> &str {
        self.chain
            .frames()
            .get(self.tcp_frame)
            .map_or("", |frame| &frame.name)
    }

    /// Positions of all joints of the chain: `arm` for the controlled ones and their followers,
    /// home for the others.
    pub fn with_arm_positions(&self, arm: &[f64]) -> Vec<f64> {
        let mut all: Vec<f64> = self.joints.iter().map(|spec| spec.home).collect();
        self.place_arm(arm, &mut all);
        all
    }

    /// Poses of the links (base first) in the base frame for positions of all
    /// joints of the chain.
    pub fn link_poses(&self, positions: &[f64]) -> Vec<Isometry3<f64>> {
        let mut poses = Vec::with_capacity(self.links.len());
        self.link_poses_into(positions, &mut poses);
        poses
    }

    /// As [`Robot::link_poses`], into `poses`, whose memory is used again.
    pub fn link_poses_into(&self, positions: &[f64], poses: &mut Vec<Isometry3<f64>>) {
        poses.clear();
        poses.push(Isometry3::identity());
        for (joint, position) in self.chain.joints().iter().zip(positions) {
            let parent = joint.parent.map_or(0, |parent| parent + 1);
            poses.push(poses[parent] * joint.origin * joint_motion(joint, *position));
        }
    }

    /// Pose of a frame of the chain in the base frame, for positions of all joints of the
    /// chain; `None` if there is no such frame.
    pub fn frame_pose(&self, frame: usize, positions: &[f64]) -> Option<Isometry3<f64>> {
        let frame = self.chain.frames().get(frame)?;
        let poses = self.link_poses(positions);
        poses
            .get(frame.joint.map_or(0, |joint| joint + 1))
            .map(|link| link * frame.pose)
    }
}

/// Motion of a joint from position zero (rad or m).
pub fn joint_motion(joint: &rmp::Joint, position: f64) -> Isometry3<f64> {
    match joint.kind {
        JointKind::Prismatic => Isometry3::from_parts(
            Translation3::from(joint.axis * position),
            UnitQuaternion::identity(),
        ),
        JointKind::Revolute => {
            // `libm`, not `f64::sin`, which may differ in its last bit between systems.
            let (sin, cos) = (libm::sin(0.5 * position), libm::cos(0.5 * position));
            // Of length 1, since the axis is.
            let quaternion = nalgebra::Quaternion::from_parts(cos, joint.axis * sin);
            Isometry3::from_parts(Translation3::identity(), Unit::new_unchecked(quaternion))
        }
    }
}
