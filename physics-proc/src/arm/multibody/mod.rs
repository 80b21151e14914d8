//! An arm in the engine: one reduced-coordinate multibody.
//!
//! Gravity acts on the links as joint efforts, computed in every tick from the
//! measured joints. That is the same physics as a force on each body, but the
//! engine would take in such forces in each substep before its drives answer,
//! and that makes a held object creep (measured: 0.03 mm in 10 s against 0.0007).

use cell_model::{ArmSpec, Robot};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::*;
use serde::{Deserialize, Serialize};

use crate::engine::convert;
use crate::engine::settings::TICK_S;
use crate::engine::tag::Tag;

mod joint;
mod link;

use joint::{add_drive, axis_of, engine_joint};
use link::{friction_of, insert_link};

/// Share of its effort limit that a drive keeps in any case.
// Where gravity takes the whole limit the drive would otherwise have no effort at all, not
// even its damping.
const LEAST_EFFORT: f64 = 0.05;
/// Share of its limit up to which a drive needs no limit in the engine.
// A spring exceeds half of its limit within a tick only if the joint moves by `limit / (2 *
// stiffness)`: 9.7 mrad for the Panda, 4 times its largest velocity (ADR 0032).
const FREE_EFFORT: f64 = 0.5;

/// Ticks ahead within which a limit that a joint may reach is part of the solution.
// The engine solves a row for each limit in force: with all of them the joints of the Panda
// take 44 thousand instructions in a tick, with the near ones 26.
const LIMIT_TICKS: f64 = 2.0;

/// An arm in the engine.
pub(crate) struct Arm {
    /// The robot.
    pub(super) robot: Robot,
    /// Bodies of the links, base first.
    pub(super) bodies: Vec<RigidBodyHandle>,
    /// Any joint of the multibody; `None` for a robot without joints.
    handle: Option<MultibodyJointHandle>,
    /// By joint of the chain: link in the multibody, and axis of its motion.
    places: Vec<(usize, usize)>,
}

/// Stiffness of the spring by which a drive gives an effort alone (N·m/rad or N/m).
// The engine takes no effort of a joint: a spring this soft, with its rest position far away,
// gives the same whatever the joint does within a tick.
const SOFT: f64 = 1.0e-3;

/// Makes the drive of `axis` give an effort alone.
fn give(joint: &mut MultibodyJoint, axis: usize, effort: f64) {
    let motor = JointAxesMask::from_bits_truncate(1 << axis);
    joint.data.motor_axes.set(motor, false);
    joint.set_spring(axis, SOFT, joint.coords()[axis] + effort / SOFT);
}

/// Target of a drive.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct DriveTarget {
    /// rad or m.
    pub(crate) position: f64,
    /// rad/s or m/s.
    pub(crate) velocity: f64,
    /// Feed-forward (N·m or N).
    pub(crate) effort: f64,
    /// Gravity on the arm at this joint, to be carried (N·m or N).
    pub(crate) gravity: f64,
    /// Limit of the effort (N·m or N).
    pub(crate) max_effort: f64,
    /// The drive gives `effort` alone, whatever the position.
    pub(crate) by_effort: bool,
}

impl Arm {
    /// Puts an arm into the world, at home.
    pub(crate) fn insert(world: &mut PhysicsWorld, index: usize, spec: &ArmSpec) -> Self {
        let robot = spec.robot.clone();
        // Bodies are created at the poses of the home position, so nothing moves when they are
        // joined.
        let home = robot.with_arm_positions(&spec.home);
        let poses = robot.link_poses(&home);
        let bodies = robot
            .links
            .iter()
            .zip(&poses)
            .enumerate()
            .map(|(link, (body, pose))| {
                let friction = friction_of(&robot, link);
                insert_link(
                    world,
                    Tag::Link { arm: index, link },
                    body,
                    &(spec.base * pose),
                    friction,
                )
            });
        let bodies: Vec<RigidBodyHandle> = bodies.collect();
        let mut arm = Self {
            robot,
            bodies,
            handle: None,
            places: Vec::new(),
        };
        arm.join(world);
        arm.set_positions(world, &home);
        arm
    }

    /// The robot.
    pub(crate) fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Bodies of the links, base first.
    pub(crate) fn bodies(&self) -> &[RigidBodyHandle] {
        &self.bodies
    }

    fn join(&mut self, world: &mut PhysicsWorld) {
        let followers: Vec<usize> = self.robot.followers().map(|(joint, ..)| joint).collect();
        let joints = self
            .robot
            .chain
            .joints()
            .iter()
            .zip(&self.robot.joints)
            .enumerate();
        // Parents come before children in the chain, so the body of the parent is already a
        // link.
        for (index, (joint, spec)) in joints {
            let parent = self.bodies[joint.parent.map_or(0, |parent| parent + 1)];
            let mut engine = engine_joint(joint);
            // A coupled joint has no motor: two laws for one motion would work against each
            // other.
            if !followers.contains(&index) {
                add_drive(&mut engine, joint, spec);
            }
            let body = self.bodies[index + 1];
            let inserted = world.multibody_joints.insert(parent, body, engine, true);
            self.handle = inserted.or(self.handle);
            let link = world
                .multibody_joints
                .rigid_body_link(self.bodies[index + 1]);
            self.places
                .push((link.map_or(0, |link| link.id), axis_of(joint.kind)));
        }
    }

    /// Sets the positions of all joints of the chain, and the properties that the engine only
    /// accepts once they are joined.
    fn set_positions(&self, world: &mut PhysicsWorld, positions: &[f64]) {
        let Some((multibody, _)) = self
            .handle
            .and_then(|handle| world.multibody_joints.get_mut(handle))
        else {
            return;
        };
        // Shapes of links are rounder than the robot and may overlap; contacts between them
        // would fight the joints. The spheres of the robot count real contacts instead
        // (`touch_count`).
        multibody.set_self_contacts_enabled(false);
        // Fixes the type of the root, and with it the number of coordinates.
        multibody.forward_kinematics(&world.bodies, true);
        let mut displacements = vec![0.0; multibody.ndofs()];
        let places: Vec<usize> = self
            .places
            .iter()
            .filter_map(|(link, _)| multibody.link(*link))
            .map(MultibodyLink::assembly_id)
            .collect();
        for ((&place, position), spec) in places.iter().zip(positions).zip(&self.robot.joints) {
            displacements[place] = *position;
            // Armature keeps free motion stable: without it a swinging Panda loses 24 of 102 J
            // in 10 s, with 0.1 kg m² it loses 7 (with four substeps).
            multibody.armature_mut()[place] = spec.armature;
            multibody.damping_mut()[place] = spec.joint_damping;
        }
        multibody.apply_displacements(&displacements);
        multibody.forward_kinematics(&world.bodies, false);
        // Without the coupling two saturated fingers have no stiffness along the closing axis:
        // a held cube moved by 14 mm along it.
        if let Some(gripper) = &self.robot.gripper {
            let [left, right] = gripper.finger_joints;
            multibody.add_dof_coupling(self.coupling(left, right, (1.0, 0.0)));
        }
        for (joint, place, mimic) in self.robot.followers() {
            let followed = self.robot.arm_joints[place];
            let law = (mimic.multiplier, mimic.offset);
            multibody.add_dof_coupling(self.coupling(followed, joint, law));
        }
        multibody.update_rigid_bodies(&mut world.bodies, true);
    }

    /// Joint `other` of the chain at `coeff` times the position of `joint`, plus `offset`.
    fn coupling(
        &self,
        joint: usize,
        other: usize,
        (coeff, offset): (f64, f64),
    ) -> MultibodyDofCoupling {
        let ((link1, axis1), (link2, axis2)) = (self.places[joint], self.places[other]);
        MultibodyDofCoupling {
            link1,
            dof1: 0,
            axis1,
            link2,
            dof2: 0,
            axis2,
            coeff,
            offset,
        }
    }

    /// Sets the drive of a joint of the chain. Feed-forward and gravity shift the
    /// target of the spring. The engine limits the sum of drive and gravity, so
    /// what gravity may take is kept back from the drive's limit.
    ///
    /// Where the drive is far from its limit it is a spring with damping in the mass matrix
    /// of the engine, which costs nothing more; near the limit, and beyond, it is a row of the
    /// solver, which knows the limit. Both are implicit; the state decides which one is used
    /// (ADR 0032).
    pub(crate) fn drive(&self, world: &mut PhysicsWorld, joint: usize, target: &DriveTarget) {
        let Some((multibody, _)) = self
            .handle
            .and_then(|handle| world.multibody_joints.get_mut(handle))
        else {
            return;
        };
        let (Some(&(link, axis)), Some(spec)) =
            (self.places.get(joint), self.robot.joints.get(joint))
        else {
            return;
        };
        let Some(place) = multibody.link(link).map(MultibodyLink::assembly_id) else {
            return;
        };
        let rate = multibody.generalized_velocity()[place];
        let Some(link) = multibody.link_mut(link) else {
            return;
        };
        let reach = LIMIT_TICKS * TICK_S * (rate.abs() + spec.velocity);
        // Set in every tick, from position and velocity alone: the choice needs no state, so a
        // restored run makes the same.
        limit_if_near(link, axis, reach);
        let effort = target.effort.clamp(-target.max_effort, target.max_effort);
        let rest = target.position + (effort - target.gravity) / spec.stiffness;
        // The share of gravity is taken from the limit of the drive, as on a real arm (ADR
        // 0006).
        let most = (target.max_effort - target.gravity.abs()).max(LEAST_EFFORT * target.max_effort);
        let asked = spec.stiffness * (rest - link.joint.coords()[axis])
            + spec.damping * (target.velocity - rate);
        let is_limited = asked.abs() > FREE_EFFORT * most;
        let joint = &mut link.joint;
        joint
            .data
            .motor_axes
            .set(JointAxesMask::from_bits_truncate(1 << axis), is_limited);
        let motor = &mut joint.data.motors[axis];
        (motor.target_pos, motor.target_vel, motor.max_force) = (rest, target.velocity, most);
        // Exactly one of spring and motor is active: both together would apply the law twice.
        let damping = if target.by_effort {
            let carried = target.gravity.abs();
            give(
                joint,
                axis,
                effort.clamp(-most - carried, most + carried) - target.gravity,
            );
            0.0
        } else if is_limited {
            joint.set_spring(axis, 0.0, 0.0);
            0.0
        } else {
            // The spring has no target velocity: its rest position leads by what damping
            // needs.
            let ahead = spec.damping * target.velocity / spec.stiffness;
            joint.set_spring(axis, spec.stiffness, rest + ahead);
            spec.damping
        };
        multibody.damping_mut()[place] = spec.joint_damping + damping;
    }

    /// Position and velocity of every joint of the chain.
    pub(crate) fn measure(
        &self,
        world: &PhysicsWorld,
        positions: &mut [f64],
        velocities: &mut [f64],
    ) {
        let Some((multibody, _)) = self
            .handle
            .and_then(|handle| world.multibody_joints.get(handle))
        else {
            return;
        };
        let rates = multibody.generalized_velocity();
        let outputs = positions.iter_mut().zip(velocities.iter_mut());
        for ((link, axis), (position, velocity)) in self.places.iter().zip(outputs) {
            let Some(link) = multibody.link(*link) else {
                continue;
            };
            let coordinates = link.joint.coords();
            *position = coordinates[*axis];
            *velocity = rates[link.assembly_id()];
        }
    }

    /// Effort the drive of a joint of the chain gives at a measured state: the
    /// engine solves this law within the tick and does not report it (N·m, N).
    pub(crate) fn effort(
        &self,
        joint: usize,
        target: &DriveTarget,
        position: f64,
        velocity: f64,
    ) -> f64 {
        let Some(spec) = self.robot.joints.get(joint) else {
            return 0.0;
        };
        if target.by_effort {
            return target.effort.clamp(-target.max_effort, target.max_effort);
        }
        let spring = spec.stiffness * (target.position - position)
            + spec.damping * (target.velocity - velocity);
        (spring + target.effort).clamp(-target.max_effort, target.max_effort)
    }

    /// Body that carries the tool, and the tool centre point in its frame.
    pub(crate) fn tool(&self) -> Option<(RigidBodyHandle, Isometry3<f64>)> {
        let frame = self.robot.chain.frames().get(self.robot.tcp_frame)?;
        let body = self.bodies.get(frame.joint.map_or(0, |joint| joint + 1))?;
        Some((*body, frame.pose))
    }

    /// Pose of the tool centre point in the world frame.
    pub(crate) fn tcp(&self, world: &PhysicsWorld) -> Isometry3<f64> {
        let Some((body, tool)) = self.tool() else {
            return Isometry3::identity();
        };
        let link = world
            .bodies
            .get(body)
            .map_or(Isometry3::identity(), |body| {
                convert::from_pose(body.position())
            });
        link * tool
    }
}

/// Has the engine keep the limits of a joint only if they are within `reach` of it (rad or m):
/// it solves a row for each limit in force, reached or not.
fn limit_if_near(link: &mut MultibodyLink, axis: usize, reach: f64) {
    let position = link.joint.coords()[axis];
    let joint = &mut link.joint.data;
    let limits = &joint.limits[axis];
    let is_far = position - limits.min > reach && limits.max - position > reach;
    let axes = JointAxesMask::from_bits_truncate(1 << axis);
    joint.limit_axes.set(axes, !is_far);
}
