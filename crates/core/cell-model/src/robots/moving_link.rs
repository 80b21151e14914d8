//! The links of a robot that its controlled joints move, prepared for dynamics.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use rmp::JointKind;

use crate::robots::robot::{Robot, joint_motion};
use crate::shape::Link;

/// A rotation by its columns. General products of matrices take several times as long.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RotationColumns(pub(crate) [Vector3<f64>; 3]);

impl RotationColumns {
    fn new(rotation: UnitQuaternion<f64>) -> Self {
        let matrix = rotation.to_rotation_matrix();
        Self([0, 1, 2].map(|column| matrix.matrix().column(column).into_owned()))
    }

    /// The rotation by `angle` about z, followed by this one.
    pub(crate) fn about_z(&self, angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        let [x, y, z] = self.0;
        Self([x * cos + y * sin, y * cos - x * sin, z])
    }

    /// `v` of the turned frame, in the outer frame.
    pub(crate) fn out(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.0[0] * v.x + self.0[1] * v.y + self.0[2] * v.z
    }

    /// `v` of the outer frame, in the turned frame.
    pub(crate) fn back(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let [x, y, z] = &self.0;
        Vector3::new(x.dot(v), y.dot(v), z.dot(v))
    }
}

/// An inertia tensor: xx yy zz xy xz yz (kg·m²).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Inertia([f64; 6]);

impl Inertia {
    /// The product with `v`.
    pub(crate) fn times(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Vector3::new(
            xx * v.x + xy * v.y + xz * v.z,
            xy * v.x + yy * v.y + yz * v.z,
            xz * v.x + yz * v.y + zz * v.z,
        )
    }

    fn add(&mut self, matrix: &Matrix3<f64>) {
        let at = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        for (own, place) in self.0.iter_mut().zip(at) {
            *own += matrix[place];
        }
    }
}

/// A link that moves with a controlled joint, with all links fixed to it. Its frame has the
/// joint axis as z, and its origin on it.
#[derive(Clone, Debug)]
pub(crate) struct MovingLink {
    /// The moving link that carries it; `None` for the base.
    pub(crate) parent: Option<usize>,
    pub(crate) kind: JointKind,
    /// Index of the controlled joint in the arm.
    pub(crate) place: usize,
    /// Motion of the joint per motion of the controlled joint, and its position at zero of
    /// that.
    pub(crate) ratio: f64,
    offset: f64,
    /// Rotor inertia and gear friction.
    pub(crate) drive: (f64, f64),
    /// At position zero: rotation to the frame of the parent, and origin in it (m).
    pub(crate) rotation: RotationColumns,
    pub(crate) origin: Vector3<f64>,
    /// Mass (kg).
    pub(crate) mass: f64,
    /// Mass times centre of mass (kg·m).
    pub(crate) moment: Vector3<f64>,
    /// About the origin (kg·m²).
    pub(crate) inertia: Inertia,
    /// Its mass, and those of all moving links that it carries (kg).
    pub(crate) carried_mass: f64,
}

impl MovingLink {
    /// Its share of values of the controlled joints; missing ones count as zero.
    pub(crate) fn share(&self, values: &[f64]) -> f64 {
        self.ratio * values.get(self.place).copied().unwrap_or(0.0)
    }

    /// Its position for positions of the controlled joints (rad or m).
    pub(crate) fn position(&self, positions: &[f64]) -> f64 {
        self.share(positions) + self.offset
    }

    /// Adds `body`, whose frame is at `pose`.
    fn add(&mut self, body: &Link, pose: &Isometry3<f64>) {
        let turn = pose.rotation.to_rotation_matrix();
        let center = (pose * nalgebra::Point3::from(body.center_of_mass)).coords;
        self.mass += body.mass;
        self.moment += center * body.mass;
        let own = turn.matrix() * body.inertia * turn.matrix().transpose();
        // The parallel axis theorem: from the centre of mass to the origin.
        let apart = Matrix3::identity() * center.norm_squared() - center * center.transpose();
        self.inertia.add(&(own + apart * body.mass));
    }
}

/// The moving links of a robot, each after the one that carries it.
pub(crate) fn moving_links(robot: &Robot) -> Vec<MovingLink> {
    let mut links: Vec<MovingLink> = Vec::new();
    // By joint of the chain: the moving link that its child is part of, and its pose there.
    let mut parts: Vec<(Option<usize>, Isometry3<f64>)> = Vec::new();
    for (index, joint) in robot.chain.joints().iter().enumerate() {
        let base = (None, Isometry3::identity());
        let (parent, pose) = joint.parent.map_or(base, |parent| parts[parent]);
        let at = pose * joint.origin;
        let part = match moved(robot, index) {
            None => {
                let home = robot.joints.get(index).map_or(0.0, |spec| spec.home);
                (parent, at * joint_motion(joint, home))
            }
            Some((place, ratio, offset)) => {
                let turn = from_z(&joint.axis);
                let spec = robot.joints.get(index);
                links.push(MovingLink {
                    parent,
                    kind: joint.kind,
                    place,
                    ratio,
                    offset,
                    drive: spec.map_or((0.0, 0.0), |spec| (spec.armature, spec.joint_damping)),
                    rotation: RotationColumns::new(at.rotation * turn),
                    origin: at.translation.vector,
                    mass: 0.0,
                    moment: Vector3::zeros(),
                    inertia: Inertia::default(),
                    carried_mass: 0.0,
                });
                let turned = Isometry3::from_parts(Translation3::identity(), turn.inverse());
                (Some(links.len() - 1), turned)
            }
        };
        if let (Some(link), pose) = &part {
            links[*link].add(&robot.links[index + 1], pose);
        }
        parts.push(part);
    }
    // From the tips to the base: a link's carried mass is complete before its parent needs it.
    for index in (0..links.len()).rev() {
        links[index].carried_mass += links[index].mass;
        if let Some(parent) = links[index].parent {
            links[parent].carried_mass += links[index].carried_mass;
        }
    }
    links
}

/// Coupling of a joint of the chain to a controlled one: index in the arm, ratio and offset;
/// `None` if it stays at home.
fn moved(robot: &Robot, joint: usize) -> Option<(usize, f64, f64)> {
    let mut followers = robot.followers();
    let follows = followers.find(|(follower, ..)| *follower == joint);
    if let Some((_, place, mimic)) = follows {
        return Some((place, mimic.multiplier, mimic.offset));
    }
    let place = robot.arm_joints.iter().position(|own| *own == joint)?;
    Some((place, 1.0, 0.0))
}

/// Turns z to `axis`.
fn from_z(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    // Opposite axes have no unique rotation between them; half a turn about x is one.
    UnitQuaternion::rotation_between(&Vector3::z(), axis).unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    })
}
