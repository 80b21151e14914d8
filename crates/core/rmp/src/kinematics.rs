//! Forward kinematics with velocity and bias acceleration, analytic Jacobians.
//!
//! The bias is the acceleration a point has when all joint accelerations are
//! zero, `Jdot * qd`: the curvature term every leaf needs. All vectors are in the
//! base frame.

use nalgebra::{DMatrix, Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::JointKind;
use crate::tree::{Attachment, Tree, TreeJoint};

/// Motion of one joint's child frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Link {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) origin: Vector3<f64>,
    pub(crate) axis: Vector3<f64>,
    pub(crate) angular: Vector3<f64>,
    pub(crate) linear: Vector3<f64>,
    pub(crate) angular_bias: Vector3<f64>,
    pub(crate) linear_bias: Vector3<f64>,
}

const REST: Link = Link {
    rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    origin: Vector3::new(0.0, 0.0, 0.0),
    axis: Vector3::new(0.0, 0.0, 0.0),
    angular: Vector3::new(0.0, 0.0, 0.0),
    linear: Vector3::new(0.0, 0.0, 0.0),
    angular_bias: Vector3::new(0.0, 0.0, 0.0),
    linear_bias: Vector3::new(0.0, 0.0, 0.0),
};

/// Position, velocity and bias acceleration of a point, base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMotion {
    /// m.
    pub position: Vector3<f64>,
    /// m/s.
    pub velocity: Vector3<f64>,
    /// Acceleration at zero joint acceleration (`Jdot * qd`), m/s^2.
    pub bias: Vector3<f64>,
}

/// Kinematics of the controlled joints at the state last given to `update`.
#[derive(Debug, Clone)]
pub(crate) struct Kinematics {
    pub(crate) tree: Tree,
    pub(crate) links: Vec<Link>,
}

impl Kinematics {
    pub(crate) fn new(tree: Tree) -> Self {
        let links = vec![REST; tree.joints.len()];
        Self { tree, links }
    }

    /// Recomputes every link for joint positions `q` and velocities `qd`, both in
    /// the order of the controlled joints.
    pub(crate) fn update(&mut self, q: &[f64], qd: &[f64]) {
        // Parents come before children, so one pass suffices.
        for (index, joint) in self.tree.joints.iter().enumerate() {
            let parent = joint.parent.map_or(&REST, |p| &self.links[p]);
            let (position, velocity) = (joint.ratio * q[joint.slot], joint.ratio * qd[joint.slot]);
            self.links[index] = advance(parent, joint, position, velocity);
        }
    }

    pub(crate) fn link(&self, attachment: &Attachment) -> &Link {
        self.link_of(attachment.joint)
    }

    /// The link that `joint` moves; `None` is the base.
    #[inline]
    pub(crate) fn link_of(&self, joint: Option<usize>) -> &Link {
        joint.map_or(&REST, |j| &self.links[j])
    }

    /// Position of a point that is fixed in the frame of a joint (m).
    pub(crate) fn place(&self, joint: Option<usize>, offset: &Vector3<f64>) -> Vector3<f64> {
        let link = self.link_of(joint);
        link.origin + link.rotation * offset
    }

    /// Motion of the attachment's origin.
    pub(crate) fn point(&self, attachment: &Attachment) -> PointMotion {
        let link = self.link(attachment);
        let arm = link.rotation * attachment.offset;
        let turning = link.angular.cross(&arm);
        PointMotion {
            position: link.origin + arm,
            velocity: link.linear + turning,
            bias: link.linear_bias + link.angular_bias.cross(&arm) + link.angular.cross(&turning),
        }
    }

    pub(crate) fn rotation(&self, attachment: &Attachment) -> Matrix3<f64> {
        self.link(attachment).rotation * attachment.rotation
    }

    pub(crate) fn pose(&self, attachment: &Attachment) -> Isometry3<f64> {
        let rotation = Rotation3::from_matrix_unchecked(self.rotation(attachment));
        Isometry3::from_parts(
            Translation3::from(self.point(attachment).position),
            UnitQuaternion::from_rotation_matrix(&rotation),
        )
    }

    /// Writes the 6 x N Jacobian of the attachment's origin, rows linear (m) then
    /// angular (rad), columns in the order of the controlled joints.
    pub(crate) fn jacobian(&self, attachment: &Attachment, out: &mut DMatrix<f64>) {
        // Joints that are not between the base and the attachment do not move it: zero
        // columns.
        out.fill(0.0);
        let position = self.point(attachment).position;
        let mut next = attachment.joint;
        while let Some(index) = next {
            let (joint, link) = (&self.tree.joints[index], &self.links[index]);
            let (linear, angular) = match joint.kind {
                JointKind::Revolute => (link.axis.cross(&(position - link.origin)), link.axis),
                JointKind::Prismatic => (link.axis, Vector3::zeros()),
            };
            // Joints that follow another one share its column.
            let mut add = |row: usize, part: Vector3<f64>| {
                let mut column = out.fixed_view_mut::<3, 1>(row, joint.slot);
                column += part * joint.ratio;
            };
            add(0, linear);
            add(3, angular);
            next = joint.parent;
        }
    }
}

/// Motion of a joint's child frame from that of its parent.
#[inline]
fn advance(parent: &Link, joint: &TreeJoint, position: f64, velocity: f64) -> Link {
    let turned = parent.rotation * joint.rotation;
    let axis: Vector3<f64> = turned.column(2).into_owned();
    let mut arm = parent.rotation * joint.offset;
    let slide = axis * velocity;
    // Every axis is the local z axis, so a rotation only mixes two columns.
    let (rotation, spin, slip) = match joint.kind {
        JointKind::Revolute => {
            let (sine, cosine) = libm::sincos(position);
            let (x, y) = (turned.column(0), turned.column(1));
            let columns = [x * cosine + y * sine, y * cosine - x * sine, axis];
            (Matrix3::from_columns(&columns), slide, Vector3::zeros())
        }
        JointKind::Prismatic => {
            arm += axis * position;
            (turned, Vector3::zeros(), slide)
        }
    };
    let turning = parent.angular.cross(&arm);
    Link {
        rotation,
        origin: parent.origin + arm,
        axis,
        angular: parent.angular + spin,
        linear: parent.linear + turning + slip,
        angular_bias: parent.angular_bias + parent.angular.cross(&spin),
        // Centripetal and Coriolis parts; the factor two is that of a slide in a turning
        // frame.
        linear_bias: parent.linear_bias
            + parent.angular_bias.cross(&arm)
            + parent.angular.cross(&turning)
            + parent.angular.cross(&slip) * 2.0,
    }
}
