//! The controlled part of a [`Chain`]: fixed joints are folded into constants, and every axis
//! is turned onto the local z axis, so that a joint costs one mixing of two columns.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::{Chain, Frame, Joint, JointKind, SetupError};

/// One moving joint with the axis z: a controlled one, or one that follows it.
#[derive(Debug, Clone)]
pub struct TreeJoint {
    /// Index of the joint it moves with in evaluation order; `None` is the base.
    pub parent: Option<usize>,
    /// Index in the caller's order of controlled joints; for a joint that follows another one,
    /// the index of that one.
    pub slot: usize,
    /// Motion (rad or m) per motion of the controlled joint: 1, or the multiplier of a joint
    /// that follows.
    pub ratio: f64,
    /// Whether it turns about z or slides along z.
    pub kind: JointKind,
    /// Rotation in the parent's aligned frame at position zero.
    pub rotation: Matrix3<f64>,
    /// Offset (m) in the parent's aligned frame at position zero.
    pub offset: Vector3<f64>,
}

/// A pose that moves rigidly with one controlled joint, or with none.
#[derive(Debug, Clone)]
pub(crate) struct Attachment {
    /// Index in evaluation order; `None` is fixed in the base.
    pub(crate) joint: Option<usize>,
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) offset: Vector3<f64>,
}

/// Index in evaluation order of the controlled joint that a frame moves with (`None` is the
/// base), and the pose of the frame in the aligned frame of that joint.
pub type Carrier = (Option<usize>, Isometry3<f64>);

/// Controlled joints, and those that follow them, in evaluation order (parents first).
#[derive(Debug, Clone)]
pub struct Tree {
    pub(crate) joints: Vec<TreeJoint>,
    /// For each joint of the chain: the joint that carries its child frame.
    carriers: Vec<Carrier>,
}

impl Tree {
    /// Folds `chain` down to the joints named in `controlled` and those that follow them; all
    /// others are constant at their default position (by default zero, moved into their
    /// limits).
    ///
    /// # Errors
    /// [`SetupError`] if no joint is named, a joint is named twice or is not in the chain, or
    /// a default position is not finite.
    pub fn new(
        chain: &Chain,
        controlled: &[String],
        defaults: &BTreeMap<String, f64>,
    ) -> Result<Self, SetupError> {
        check_names(chain, controlled, defaults)?;
        let mut tree = Self {
            joints: Vec::with_capacity(controlled.len()),
            carriers: Vec::with_capacity(chain.joints().len()),
        };
        for joint in chain.joints() {
            let (carrier, pose) = tree.carrier(joint.parent);
            let origin = pose * joint.origin;
            let slot_of = |joint: &Joint| controlled.iter().position(|name| *name == joint.name);
            let followed = joint.mimic.and_then(|mimic| {
                let slot = slot_of(chain.joints().get(mimic.joint)?)?;
                Some((slot, mimic))
            });
            // A follower is a joint with the slot of the one it follows; all others are
            // constants.
            let folded = match (slot_of(joint), followed) {
                (Some(slot), _) => tree.add(joint, (slot, 1.0), carrier, &origin),
                (None, Some((slot, mimic))) => {
                    let origin = origin * motion(joint, mimic.offset);
                    tree.add(joint, (slot, mimic.multiplier), carrier, &origin)
                }
                (None, None) => (carrier, origin * motion(joint, default_of(joint, defaults))),
            };
            tree.carriers.push(folded);
        }
        Ok(tree)
    }

    /// The moving joints in evaluation order: a parent comes before its children.
    pub fn joints(&self) -> &[TreeJoint] {
        &self.joints
    }

    /// The joint that carries a frame of the chain of this tree, and the pose of the frame
    /// there.
    pub fn carrier_of(&self, frame: &Frame) -> Carrier {
        let (joint, pose) = self.carrier(frame.joint);
        (joint, pose * frame.pose)
    }

    /// The attachment of a frame of the chain, moved by `local` (m, in the frame).
    pub(crate) fn attach(&self, frame: &Frame, local: Vector3<f64>) -> Attachment {
        let (joint, pose) = self.carrier_of(frame);
        let pose = pose * Translation3::from(local);
        Attachment {
            joint,
            rotation: pose.rotation.to_rotation_matrix().into_inner(),
            offset: pose.translation.vector,
        }
    }

    fn carrier(&self, chain_joint: Option<usize>) -> Carrier {
        chain_joint
            .and_then(|j| self.carriers.get(j).copied())
            .unwrap_or((None, Isometry3::identity()))
    }

    fn add(
        &mut self,
        joint: &Joint,
        (slot, ratio): (usize, f64),
        carrier: Option<usize>,
        origin: &Isometry3<f64>,
    ) -> Carrier {
        // The rotation is not unique for the axis -z: half a turn about x is taken.
        let align =
            UnitQuaternion::rotation_between(&Vector3::z(), &joint.axis).unwrap_or_else(|| {
                UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(0.0, 1.0, 0.0, 0.0))
            });
        self.joints.push(TreeJoint {
            parent: carrier,
            slot,
            ratio,
            kind: joint.kind,
            rotation: (origin.rotation * align).to_rotation_matrix().into_inner(),
            offset: origin.translation.vector,
        });
        let child = Isometry3::from_parts(Translation3::identity(), align.inverse());
        (Some(self.joints.len() - 1), child)
    }
}

fn motion(joint: &Joint, position: f64) -> Isometry3<f64> {
    match joint.kind {
        JointKind::Revolute => Isometry3::from_parts(
            Translation3::identity(),
            UnitQuaternion::new(joint.axis * position),
        ),
        JointKind::Prismatic => Isometry3::from(Translation3::from(joint.axis * position)),
    }
}

/// Default position of a joint: as given, else zero moved into the limits.
pub(crate) fn default_of(joint: &Joint, defaults: &BTreeMap<String, f64>) -> f64 {
    defaults
        .get(&joint.name)
        .copied()
        .unwrap_or_else(|| 0.0_f64.max(joint.lower).min(joint.upper))
}

fn check_names(
    chain: &Chain,
    controlled: &[String],
    defaults: &BTreeMap<String, f64>,
) -> Result<(), SetupError> {
    if controlled.is_empty() {
        return Err(SetupError::NoJoints);
    }
    for (index, name) in controlled.iter().enumerate() {
        if chain.joint_index(name).is_none() {
            return Err(SetupError::UnknownJoint { name: name.clone() });
        }
        if controlled.iter().take(index).any(|other| other == name) {
            return Err(SetupError::RepeatedJoint { name: name.clone() });
        }
    }
    // A misspelt name would otherwise leave its joint at zero without notice.
    for (name, &value) in defaults {
        if chain.joint_index(name).is_none() {
            return Err(SetupError::UnknownJoint { name: name.clone() });
        }
        if !value.is_finite() {
            return Err(SetupError::NotFinite {
                what: format!("default position of joint '{name}'"),
                value,
            });
        }
    }
    Ok(())
}
