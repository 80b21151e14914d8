//! Inverse dynamics: the joint efforts for a commanded motion of the arm.
//!
//! Recursive Newton-Euler in the frames of the links (Luh, Walker and Paul 1980; Featherstone,
//! "Rigid Body Dynamics Algorithms", chapter 5): velocities and accelerations outwards, forces
//! inwards. The frame of a moving link has its joint axis as z; links fixed to it are part of
//! it.

use nalgebra::Vector3;
use rmp::JointKind;

use crate::robots::moving_link::{MovingLink, RotationColumns, moving_links};
use crate::robots::robot::Robot;

/// Standard gravity in the world frame (m/s²).
pub const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Inverse dynamics of the controlled joints of one robot. Joints that follow one of them load
/// its drive. Other joints (the fingers) count as fixed at home, with their masses.
#[derive(Clone, Debug)]
pub struct Dynamics {
    links: Vec<MovingLink>,
    /// By moving link.
    motion: Vec<Motion>,
    efforts: Vec<f64>,
}

/// State of one link in its own frame during the recursion.
#[derive(Clone, Debug, Default)]
struct Motion {
    /// Rotation to the frame of the parent link, and origin in it (m).
    rotation: RotationColumns,
    offset: Vector3<f64>,
    spin: Vector3<f64>,
    turn: Vector3<f64>,
    /// Acceleration of the link's origin, with gravity as an acceleration of the base.
    acceleration: Vector3<f64>,
    force: Vector3<f64>,
    /// Torque about the link's origin.
    torque: Vector3<f64>,
}

impl Dynamics {
    /// Prepares the recursion; later calls do not allocate.
    pub fn new(robot: &Robot) -> Self {
        let links = moving_links(robot);
        Self {
            motion: vec![Motion::default(); links.len()],
            efforts: vec![0.0; robot.arm_joints.len()],
            links,
        }
    }

    /// Efforts of the controlled joints (N·m or N) for their positions, velocities and
    /// accelerations, with gravity in the base frame (m/s²). They include gravity, Coriolis and
    /// inertial terms, rotor inertia and gear friction. Missing entries count as zero; surplus
    /// ones are ignored.
    pub fn inverse_dynamics(
        &mut self,
        positions: &[f64],
        velocities: &[f64],
        accelerations: &[f64],
        gravity: &Vector3<f64>,
    ) -> &[f64] {
        // Gravity as an upward acceleration of the base saves a term for each link.
        let base = Motion {
            acceleration: -gravity,
            ..Motion::default()
        };
        for (index, link) in self.links.iter().enumerate() {
            let (before, rest) = self.motion.split_at_mut(index);
            let parent = link.parent.and_then(|parent| before.get(parent));
            if let Some(motion) = rest.first_mut() {
                motion.place(link, link.position(positions));
                let rates = (link.share(velocities), link.share(accelerations));
                motion.outwards(link, parent.unwrap_or(&base), rates);
            }
        }
        self.efforts.fill(0.0);
        for (index, link) in self.links.iter().enumerate().rev() {
            let (before, rest) = self.motion.split_at_mut(index);
            let Some(motion) = rest.first() else { continue };
            let along = match link.kind {
                JointKind::Revolute => motion.torque.z,
                JointKind::Prismatic => motion.force.z,
            };
            let (armature, damping) = link.drive;
            let own = armature * link.share(accelerations) + damping * link.share(velocities);
            // Added: joints that follow another one load the same drive.
            self.efforts[link.place] += link.ratio * (along + own);
            if let Some(parent) = link.parent.and_then(|parent| before.get_mut(parent)) {
                let force = motion.rotation.out(&motion.force);
                parent.force += force;
                parent.torque += motion.rotation.out(&motion.torque) + motion.offset.cross(&force);
            }
        }
        &self.efforts
    }

    /// [`Dynamics::inverse_dynamics`] at rest: the efforts that carry the arm (N·m or N) at
    /// positions of the controlled joints, with gravity in the base frame (m/s²). A separate
    /// recursion, because physics computes it in every tick (ADR 0006).
    pub fn gravity_efforts(&mut self, positions: &[f64], gravity: &Vector3<f64>) -> &[f64] {
        for (index, link) in self.links.iter().enumerate() {
            let (before, rest) = self.motion.split_at_mut(index);
            let parent = link.parent.and_then(|parent| before.get(parent));
            if let Some(motion) = rest.first_mut() {
                motion.place(link, link.position(positions));
                let down = parent.map_or(-gravity, |parent| parent.acceleration);
                motion.acceleration = motion.rotation.back(&down);
                // Mass times centre of mass of the link and of all links that it carries.
                motion.force = link.moment;
            }
        }
        self.efforts.fill(0.0);
        for (index, link) in self.links.iter().enumerate().rev() {
            let (before, rest) = self.motion.split_at_mut(index);
            let Some(motion) = rest.first() else { continue };
            let (moment, up) = (&motion.force, &motion.acceleration);
            let along = match link.kind {
                JointKind::Revolute => moment.x * up.y - moment.y * up.x,
                JointKind::Prismatic => link.carried_mass * up.z,
            };
            self.efforts[link.place] += link.ratio * along;
            if let Some(parent) = link.parent.and_then(|parent| before.get_mut(parent)) {
                parent.force += motion.rotation.out(moment) + motion.offset * link.carried_mass;
            }
        }
        &self.efforts
    }
}

impl Motion {
    /// Sets the pose of the link for its joint at `position` (rad or m).
    fn place(&mut self, link: &MovingLink, position: f64) {
        (self.rotation, self.offset) = (link.rotation, link.origin);
        match link.kind {
            JointKind::Revolute => self.rotation = link.rotation.about_z(position),
            JointKind::Prismatic => self.offset += link.rotation.0[2] * position,
        }
    }

    /// Motion of the link from that of its parent, and the force and torque that its mass
    /// needs.
    fn outwards(&mut self, link: &MovingLink, parent: &Self, (rate, change): (f64, f64)) {
        let turn_in = |v: &Vector3<f64>| self.rotation.back(v);
        let carried = parent.acceleration
            + parent.turn.cross(&self.offset)
            + parent.spin.cross(&parent.spin.cross(&self.offset));
        let (mut spin, mut turn) = (turn_in(&parent.spin), turn_in(&parent.turn));
        let mut acceleration = turn_in(&carried);
        match link.kind {
            JointKind::Revolute => {
                turn += Vector3::new(spin.y * rate, -spin.x * rate, change);
                spin.z += rate;
            }
            JointKind::Prismatic => {
                let swept = 2.0 * rate;
                acceleration += Vector3::new(spin.y * swept, -spin.x * swept, change);
            }
        }
        self.force = acceleration * link.mass
            + turn.cross(&link.moment)
            + spin.cross(&spin.cross(&link.moment));
        self.torque = link.inertia.times(&turn)
            + spin.cross(&link.inertia.times(&spin))
            + link.moment.cross(&acceleration);
        (self.spin, self.turn, self.acceleration) = (spin, turn, acceleration);
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
    fn efforts_of_gravity_are_those_at_rest() {
        let data = Data::checkout();
        let robots = ["panda", "ur10"].map(|name| Robot::load(&data, name).unwrap());
        let tilted = Vector3::new(1.0, -3.0, -8.0);
        for robot in robots {
            let mut dynamics = Dynamics::new(&robot);
            let q = [0.3, -0.4, 0.2, -1.9, 0.5, 1.7, 0.6];
            let at_rest = dynamics.inverse_dynamics(&q, &[], &[], &tilted).to_vec();
            let carried = dynamics.gravity_efforts(&q, &tilted);
            let differ = |(one, other): (&f64, &f64)| (one - other).abs() > 1e-12;
            assert!(
                !carried.iter().zip(&at_rest).any(differ),
                "{carried:?} {at_rest:?}"
            );
        }
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
