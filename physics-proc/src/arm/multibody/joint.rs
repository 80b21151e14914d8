//! The joints of an arm as joints of the engine.

use cell_model::JointSpec;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapier3d_f64::prelude::*;
use rmp::JointKind;

use crate::engine::convert;

/// Axis of the engine about or along which a joint moves.
pub(super) fn axis_of(kind: JointKind) -> usize {
    match kind {
        JointKind::Prismatic => JointAxis::LinX as usize,
        JointKind::Revolute => JointAxis::AngX as usize,
    }
}

/// The engine's joints move about or along x.
pub(super) fn engine_joint(joint: &rmp::Joint) -> GenericJoint {
    let locked = match joint.kind {
        JointKind::Prismatic => JointAxesMask::LOCKED_PRISMATIC_AXES,
        JointKind::Revolute => JointAxesMask::LOCKED_REVOLUTE_AXES,
    };
    // Opposite axes have no unique rotation between them: half a turn about y is as good as
    // any.
    let turn = UnitQuaternion::rotation_between(&Vector3::x(), &joint.axis).unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI)
    });
    let turn = Isometry3::from_parts(Translation3::identity(), turn);
    let mut engine = GenericJoint::new(locked);
    engine.local_frame1 = convert::to_pose(&(joint.origin * turn));
    engine.local_frame2 = convert::to_pose(&turn);
    // Shapes of neighbouring links overlap at the joint.
    engine.contacts_enabled = false;
    engine
}

/// The drive and the limits of a joint that moves independently. A joint that follows another
/// one has those of that joint.
pub(super) fn add_drive(engine: &mut GenericJoint, joint: &rmp::Joint, spec: &JointSpec) {
    let axis = match joint.kind {
        JointKind::Prismatic => JointAxis::LinX,
        JointKind::Revolute => JointAxis::AngX,
    };
    engine.set_limits(axis, [joint.lower, joint.upper]);
    // The engine's default is relative to the mass; stiffness and limits of a drive are
    // absolute.
    engine.set_motor_model(axis, MotorModel::ForceBased);
    engine.set_motor(axis, spec.home, 0.0, spec.stiffness, spec.damping);
    engine.set_motor_max_force(axis, spec.effort);
}
