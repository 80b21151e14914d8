//! Pullback of leaves to the joints: task-space weights and forces are gathered
//! per link as spatial 6 x 6 forms about the base origin and carried from the tips
//! to the base in one pass, as a composite rigid body would be.
//!
//! For a leaf with Jacobian J, weight M and force f = M a the root receives
//! `J^T M J` and `J^T (f - M Jdot qd)` (`RMPflow`, arXiv 1811.07049).

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::JointKind;
use crate::kinematics::{Kinematics, Link};
use crate::tree::Attachment;

/// The sum of all leaves in joint space, in the order of the controlled joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Root {
    /// Symmetric, positive semi-definite.
    pub metric: DMatrix<f64>,
    /// `metric * acceleration`.
    pub force: DVector<f64>,
}

impl Root {
    pub(crate) fn new(joints: usize) -> Self {
        Self {
            metric: DMatrix::zeros(joints, joints),
            force: DVector::zeros(joints),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.metric.fill(0.0);
        self.force.fill(0.0);
    }

    /// Adds a leaf on one joint coordinate: weight and force.
    #[inline]
    pub(crate) fn add_joint(&mut self, slot: usize, weight: f64, force: f64) {
        self.metric[(slot, slot)] += weight;
        self.force[slot] += force;
    }
}

/// A quadratic form on the spatial velocity (angular, linear about the base
/// origin) of one link, with its force.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spatial {
    pub(crate) angular: Matrix3<f64>,
    /// Angular rows, linear columns.
    pub(crate) cross: Matrix3<f64>,
    pub(crate) linear: Matrix3<f64>,
    pub(crate) torque: Vector3<f64>,
    pub(crate) force: Vector3<f64>,
}

const EMPTY: Spatial = {
    let zero = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    Spatial {
        angular: zero,
        cross: zero,
        linear: zero,
        torque: Vector3::new(0.0, 0.0, 0.0),
        force: Vector3::new(0.0, 0.0, 0.0),
    }
};

/// Preallocated gatherer.
#[derive(Debug, Clone)]
pub(crate) struct Pullback {
    links: Vec<Spatial>,
    /// Screw (angular, linear) of every joint about the base origin.
    screws: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl Pullback {
    pub(crate) fn new(joints: usize) -> Self {
        Self {
            links: vec![EMPTY; joints],
            screws: vec![(Vector3::zeros(), Vector3::zeros()); joints],
        }
    }

    pub(crate) fn clear(&mut self) {
        self.links.fill(EMPTY);
    }

    /// Adds the lifted leaves on points of one link.
    #[inline]
    pub(crate) fn add(&mut self, joint: usize, sum: &Spatial) {
        self.links[joint].merge(sum);
    }

    /// Adds a leaf on the position of a point: `metric` (symmetric) and the force
    /// with the curvature already taken off.
    #[inline]
    pub(crate) fn add_point(
        &mut self,
        attachment: &Attachment,
        position: &Vector3<f64>,
        metric: &Matrix3<f64>,
        force: &Vector3<f64>,
    ) {
        // A point that is fixed in the base moves with no joint.
        let Some(joint) = attachment.joint else {
            return;
        };
        let link = &mut self.links[joint];
        let lever = position.cross_matrix();
        let cross = lever * metric;
        link.angular -= cross * lever;
        link.cross += cross;
        link.linear += metric;
        link.torque += position.cross(force);
        link.force += force;
    }

    /// Adds a leaf on a direction `axis` fixed in the link: weight times identity,
    /// and the force with the curvature already taken off.
    pub(crate) fn add_direction(
        &mut self,
        attachment: &Attachment,
        axis: &Vector3<f64>,
        weight: f64,
        force: &Vector3<f64>,
    ) {
        let Some(joint) = attachment.joint else {
            return;
        };
        let link = &mut self.links[joint];
        link.angular +=
            (Matrix3::identity() * axis.norm_squared() - axis * axis.transpose()) * weight;
        link.torque += axis.cross(force);
    }

    /// Carries everything gathered to the joints and adds it to `root`.
    pub(crate) fn collect(&mut self, kinematics: &Kinematics, root: &mut Root) {
        let joints = &kinematics.tree.joints;
        for ((screw, joint), link) in self.screws.iter_mut().zip(joints).zip(&kinematics.links) {
            let (turn, shift) = screw_of(joint.kind, link);
            *screw = (turn * joint.ratio, shift * joint.ratio);
        }
        // From the tips: each link has the sums of all links beyond it when its joint is
        // reached, so no leaf needs a row of the Jacobian.
        for index in (0..joints.len()).rev() {
            let sum = self.links[index];
            let (slot, parent) = (joints[index].slot, joints[index].parent);
            let (angular, linear) = self.screws[index];
            let torque = sum.angular * angular + sum.cross * linear;
            let force = sum.cross.tr_mul(&angular) + sum.linear * linear;
            root.force[slot] += sum.torque.dot(&angular) + sum.force.dot(&linear);
            root.metric[(slot, slot)] += torque.dot(&angular) + force.dot(&linear);
            // The metric couples a joint with all joints between it and the base.
            let mut ancestor = parent;
            while let Some(above) = ancestor {
                let (turn, shift) = &self.screws[above];
                let value = torque.dot(turn) + force.dot(shift);
                let other = joints[above].slot;
                root.metric[(slot, other)] += value;
                root.metric[(other, slot)] += value;
                ancestor = joints[above].parent;
            }
            // The parent now carries all links beyond it; its own turn comes later.
            if let Some(above) = parent {
                self.links[above].merge(&sum);
            }
        }
    }
}

impl Spatial {
    #[inline]
    fn merge(&mut self, other: &Self) {
        self.angular += other.angular;
        self.cross += other.cross;
        self.linear += other.linear;
        self.torque += other.torque;
        self.force += other.force;
    }
}

#[inline]
fn screw_of(kind: JointKind, link: &Link) -> (Vector3<f64>, Vector3<f64>) {
    match kind {
        JointKind::Revolute => (link.axis, link.origin.cross(&link.axis)),
        JointKind::Prismatic => (Vector3::zeros(), link.axis),
    }
}
