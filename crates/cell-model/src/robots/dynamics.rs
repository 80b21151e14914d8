//! Inverse dynamics: the joint efforts that make the arm move as commanded.
//!
//! Recursive Newton-Euler in the base frame (Luh, Walker and Paul 1980;
//! Featherstone, "Rigid Body Dynamics Algorithms", chapter 5): velocities and
//! accelerations outwards, forces inwards.

use nalgebra::{Isometry3, Matrix3, Vector3};
use rmp::{Joint, JointKind};

use crate::robots::robot::{Robot, joint_motion};

/// Inverse dynamics of the controlled joints of one robot. Joints that follow one of them
/// load its drive. Other joints (the fingers) are taken as standing at home; their masses
/// count.
#[derive(Clone, Debug)]
pub struct Dynamics {
    joints: Vec<Joint>,
    bodies: Vec<Body>,
    /// By joint of the chain; `None` where it stands at home.
    moves: Vec<Option<Moves>>,
    home: Vec<f64>,
    motion: Vec<Motion>,
    efforts: Vec<f64>,
}

/// How a joint moves with a controlled one.
#[derive(Clone, Copy, Debug)]
struct Moves {
    /// Place of the controlled joint in the arm.
    place: usize,
    /// Its motion for one of the controlled joint, and its position at zero.
    ratio: f64,
    offset: f64,
    /// Rotor inertia and gear friction.
    drive: (f64, f64),
}

#[derive(Clone, Debug)]
struct Body {
    mass: f64,
    center: Vector3<f64>,
    inertia: Matrix3<f64>,
}

/// State of one link in the base frame during the recursion.
#[derive(Clone, Debug, Default)]
struct Motion {
    pose: Isometry3<f64>,
    axis: Vector3<f64>,
    angular_velocity: Vector3<f64>,
    angular_acceleration: Vector3<f64>,
    /// Of the link's origin, with gravity as an acceleration of the base.
    acceleration: Vector3<f64>,
    force: Vector3<f64>,
    /// About the link's origin.
    torque: Vector3<f64>,
}

impl Moves {
    /// Its share of values of the controlled joints; missing ones count as zero.
    fn of(&self, values: &[f64]) -> f64 {
        self.ratio * values.get(self.place).copied().unwrap_or(0.0)
    }
}

fn moves(robot: &Robot) -> Vec<Option<Moves>> {
    let drive = |joint: usize| {
        let spec = robot.joints.get(joint);
        spec.map_or((0.0, 0.0), |spec| (spec.armature, spec.joint_damping))
    };
    let mut moves = vec![None; robot.chain.joints().len()];
    for (place, &joint) in robot.arm_joints.iter().enumerate() {
        moves[joint] = Some(Moves {
            place,
            ratio: 1.0,
            offset: 0.0,
            drive: drive(joint),
        });
    }
    for (joint, place, mimic) in robot.followers() {
        moves[joint] = Some(Moves {
            place,
            ratio: mimic.multiplier,
            offset: mimic.offset,
            drive: drive(joint),
        });
    }
    moves
}

impl Dynamics {
    /// Prepares the recursion; afterwards nothing is allocated.
    pub fn new(robot: &Robot) -> Self {
        let bodies = robot.links.iter().skip(1);
        Self {
            joints: robot.chain.joints().to_vec(),
            bodies: bodies
                .map(|l| Body {
                    mass: l.mass,
                    center: l.center_of_mass,
                    inertia: l.inertia,
                })
                .collect(),
            moves: moves(robot),
            home: robot.joints.iter().map(|spec| spec.home).collect(),
            motion: vec![Motion::default(); robot.chain.joints().len()],
            efforts: vec![0.0; robot.arm_joints.len()],
        }
    }

    /// Efforts of the controlled joints (N·m or N) for their positions,
    /// velocities and accelerations, with gravity in the base frame (m/s²):
    /// gravity, Coriolis and inertial terms, rotor inertia and gear friction.
    /// Missing entries count as zero, surplus ones are ignored.
    pub fn inverse_dynamics(
        &mut self,
        positions: &[f64],
        velocities: &[f64],
        accelerations: &[f64],
        gravity: &Vector3<f64>,
    ) -> &[f64] {
        for index in 0..self.joints.len() {
            let (mut q, mut qd, mut qdd) = (self.home[index], 0.0, 0.0);
            if let Some(moves) = self.moves[index] {
                q = moves.of(positions) + moves.offset;
                (qd, qdd) = (moves.of(velocities), moves.of(accelerations));
            }
            self.outwards(index, q, qd, qdd, gravity);
        }
        for index in (0..self.joints.len()).rev() {
            self.inwards(index);
        }
        self.efforts.fill(0.0);
        for (index, moves) in self.moves.iter().enumerate() {
            let Some(moves) = moves else {
                continue;
            };
            let motion = &self.motion[index];
            let along = match self.joints[index].kind {
                JointKind::Revolute => motion.torque,
                JointKind::Prismatic => motion.force,
            };
            let (armature, damping) = moves.drive;
            let effort = motion.axis.dot(&along)
                + armature * moves.of(accelerations)
                + damping * moves.of(velocities);
            self.efforts[moves.place] += moves.ratio * effort;
        }
        &self.efforts
    }

    fn outwards(&mut self, index: usize, q: f64, qd: f64, qdd: f64, gravity: &Vector3<f64>) {
        let joint = &self.joints[index];
        let base = Motion {
            acceleration: -gravity,
            ..Motion::default()
        };
        let parent = joint.parent.map_or(&base, |parent| &self.motion[parent]);
        let pose = parent.pose * joint.origin * joint_motion(joint, q);
        let axis = pose.rotation * joint.axis;
        let offset = pose.translation.vector - parent.pose.translation.vector;
        let (spin, turn) = (parent.angular_velocity, parent.angular_acceleration);
        let mut next = Motion {
            pose,
            axis,
            angular_velocity: spin,
            angular_acceleration: turn,
            acceleration: parent.acceleration
                + turn.cross(&offset)
                + spin.cross(&spin.cross(&offset)),
            ..Motion::default()
        };
        match joint.kind {
            JointKind::Revolute => {
                next.angular_velocity += axis * qd;
                next.angular_acceleration += axis * qdd + spin.cross(&(axis * qd));
            }
            JointKind::Prismatic => {
                next.acceleration += axis * qdd + 2.0 * spin.cross(&(axis * qd));
            }
        }
        let body = &self.bodies[index];
        let (spin, turn) = (next.angular_velocity, next.angular_acceleration);
        let rotation = pose.rotation.to_rotation_matrix();
        let center = rotation * body.center;
        let inertia = rotation.matrix() * body.inertia * rotation.matrix().transpose();
        next.force = (next.acceleration + turn.cross(&center) + spin.cross(&spin.cross(&center)))
            * body.mass;
        next.torque = inertia * turn + spin.cross(&(inertia * spin)) + center.cross(&next.force);
        self.motion[index] = next;
    }

    /// Hands force and torque of a link on to its parent.
    fn inwards(&mut self, index: usize) {
        let Some(parent) = self.joints[index].parent else {
            return;
        };
        let (force, torque) = (self.motion[index].force, self.motion[index].torque);
        let offset = self.motion[index].pose.translation.vector
            - self.motion[parent].pose.translation.vector;
        self.motion[parent].force += force;
        self.motion[parent].torque += torque + offset.cross(&force);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Data;

    const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);
    const ZERO: [f64; 7] = [0.0; 7];

    fn panda() -> Robot {
        Robot::load(&Data::checkout(), "panda").unwrap()
    }

    /// Potential energy in gravity (J).
    fn potential(robot: &Robot, q: &[f64]) -> f64 {
        let poses = robot.link_poses(&robot.with_arm_positions(q));
        let heights = robot.links.iter().zip(&poses).map(|(link, pose)| {
            let center = pose * nalgebra::Point3::from(link.center_of_mass);
            9.81 * link.mass * center.z
        });
        heights.sum()
    }

    #[test]
    fn at_rest_the_efforts_are_the_slope_of_potential_energy() {
        let robot = panda();
        let q = [0.3, -0.4, 0.2, -1.9, 0.5, 1.7, 0.6];
        let efforts = Dynamics::new(&robot)
            .inverse_dynamics(&q, &ZERO, &ZERO, &GRAVITY)
            .to_vec();
        for joint in 0..7 {
            let (mut up, mut down) = (q, q);
            up[joint] += 1e-5;
            down[joint] -= 1e-5;
            let slope = (potential(&robot, &up) - potential(&robot, &down)) / 2e-5;
            assert!(
                (efforts[joint] - slope).abs() < 1e-5,
                "joint {joint}: {} {slope}",
                efforts[joint]
            );
        }
    }

    /// Kinetic energy of links and rotors from the mass matrix (J).
    fn kinetic(robot: &Robot, q: &[f64], qd: &[f64]) -> f64 {
        let zero_gravity = Vector3::zeros();
        let mut dynamics = Dynamics::new(robot);
        // M qd from inverse dynamics with qd as the acceleration and no velocity.
        let momentum = dynamics
            .inverse_dynamics(q, &ZERO, qd, &zero_gravity)
            .to_vec();
        0.5 * momentum.iter().zip(qd).map(|(p, v)| p * v).sum::<f64>()
    }

    #[test]
    fn power_of_the_efforts_is_the_change_of_energy_and_friction() {
        let robot = panda();
        let at = |t: f64| -> (Vec<f64>, Vec<f64>, Vec<f64>) {
            let phase = |j: usize| (j as f64 + 1.0) * 0.7;
            let q = (0..7)
                .map(|j| 0.3 * libm::sin(phase(j) * t) - if j == 3 { 1.8 } else { 0.0 })
                .collect();
            let qd = (0..7)
                .map(|j| 0.3 * phase(j) * libm::cos(phase(j) * t))
                .collect();
            let qdd = (0..7)
                .map(|j| -0.3 * phase(j) * phase(j) * libm::sin(phase(j) * t))
                .collect();
            (q, qd, qdd)
        };
        let energy = |t: f64| {
            let (q, qd, _) = at(t);
            potential(&robot, &q) + kinetic(&robot, &q, &qd)
        };
        let mut dynamics = Dynamics::new(&robot);
        for t in [0.3, 1.1, 2.7] {
            let (q, qd, qdd) = at(t);
            let efforts = dynamics.inverse_dynamics(&q, &qd, &qdd, &GRAVITY);
            let power: f64 = efforts.iter().zip(&qd).map(|(e, v)| e * v).sum();
            let friction: f64 = qd.iter().map(|v| v * v).sum();
            let change = (energy(t + 1e-5) - energy(t - 1e-5)) / 2e-5;
            assert!(
                (power - friction - change).abs() < 1e-5 * change.abs().max(1.0),
                "{power} {friction} {change}"
            );
        }
    }
}
