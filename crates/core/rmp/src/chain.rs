//! The kinematic tree of a robot: actuated joints in parents-first order, and
//! named frames, every fixed link being folded into the joint it moves with.

use nalgebra::{Isometry3, Vector3};
use thiserror::Error;

/// Largest number of actuated joints of a [`Chain`].
// One bit of a 64-bit mask for each joint, as in the flags of limits.
pub const MAX_JOINTS: usize = 64;

/// How an actuated joint moves its child frame along or about its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about the axis; positions in rad.
    Revolute,
    /// Slides along the axis; positions in m.
    Prismatic,
}

/// How a joint follows another one of its chain, as the two bars of a parallelogram do: its
/// position is `multiplier * position of joint + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mimic {
    /// Index of the joint that is followed, which follows none itself.
    pub joint: usize,
    /// Not zero; negative if the two joints move against each other.
    pub multiplier: f64,
    /// rad or m.
    pub offset: f64,
}

/// One joint that moves. Its child frame is `origin` followed by the joint's
/// motion about (or along) `axis`.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// Index of the joint this one is mounted on, `None` for the base. A parent comes before
    /// its children.
    pub parent: Option<usize>,
    /// Pose of the joint at position zero in the parent joint's child frame (in the base frame
    /// for a joint without a parent), m.
    pub origin: Isometry3<f64>,
    /// Axis in the joint frame. [`Chain::new`] normalises it.
    pub axis: Vector3<f64>,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// Lower position limit, rad or m; `-inf` for a joint without limit.
    pub lower: f64,
    /// Upper position limit, rad or m; `+inf` for a joint without limit.
    pub upper: f64,
    /// The joint it follows; `None` if it moves independently.
    pub mimic: Option<Mimic>,
}

/// A named frame that moves rigidly with one joint, or is fixed in the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Unique name, usually that of the link.
    pub name: String,
    /// The joint whose child frame carries this frame; `None` for the base.
    pub joint: Option<usize>,
    /// Pose in that joint's child frame (in the base frame without joint), m.
    pub pose: Isometry3<f64>,
}

/// Why a [`Chain`] cannot be built.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ChainError {
    /// More joints than the library is built for.
    #[error("{count} actuated joints; at most {MAX_JOINTS} are supported")]
    TooManyJoints {
        /// Number of joints given.
        count: usize,
    },
    /// A parent index that does not come before the joint.
    #[error(
        "joint '{joint}' names parent {parent}, which does not come before it; list parents first"
    )]
    ParentOrder {
        /// Name of the joint.
        joint: String,
        /// The index it names.
        parent: usize,
    },
    /// A frame is attached to a joint that does not exist.
    #[error("frame '{frame}' is attached to joint {joint}, but there are {count} joints")]
    NoSuchJoint {
        /// Name of the frame.
        frame: String,
        /// The index it names.
        joint: usize,
        /// Number of joints of the chain.
        count: usize,
    },
    /// Two joints, or two frames, share a name.
    #[error("two {what}s are called '{name}'; names must be unique")]
    DuplicateName {
        /// `joint` or `frame`.
        what: &'static str,
        /// The shared name.
        name: String,
    },
    /// A number is not finite.
    #[error("the pose of {what} '{name}' has a number that is not finite")]
    NotFinite {
        /// `joint` or `frame`.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// The joint follows a joint that does not exist, or that follows another one itself.
    #[error(
        "joint '{joint}' follows joint {of}; it has to follow one of the other joints, which \
         follows none itself, with a multiplier that is not zero"
    )]
    Mimic {
        /// Name of the joint.
        joint: String,
        /// The index it names.
        of: usize,
    },
    /// The axis has no direction.
    #[error("joint '{joint}' has axis {axis:?}; an actuated joint needs an axis of nonzero length")]
    Axis {
        /// Name of the joint.
        joint: String,
        /// The axis as given.
        axis: [f64; 3],
    },
    /// The position limits are not a range.
    #[error("joint '{joint}' has limits [{lower}, {upper}]; lower must be less than upper")]
    Limits {
        /// Name of the joint.
        joint: String,
        /// Lower limit as given.
        lower: f64,
        /// Upper limit as given.
        upper: f64,
    },
}

/// A validated kinematic tree with up to [`MAX_JOINTS`] joints.
///
/// ```
/// use nalgebra::{Isometry3, Vector3};
/// use rmp::{Chain, Frame, Joint, JointKind};
///
/// let joint = Joint {
///     name: "shoulder".into(),
///     parent: None,
///     origin: Isometry3::translation(0.0, 0.0, 0.3),
///     axis: Vector3::z(),
///     kind: JointKind::Revolute,
///     lower: -2.0,
///     upper: 2.0,
///     mimic: None,
/// };
/// let tool = Frame {
///     name: "tool".into(),
///     joint: Some(0),
///     pose: Isometry3::translation(0.5, 0.0, 0.0),
/// };
/// let chain = Chain::new(vec![joint], vec![tool])?;
/// assert_eq!(chain.frame_index("tool"), Some(0));
/// # Ok::<(), rmp::ChainError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    joints: Vec<Joint>,
    frames: Vec<Frame>,
}

impl Chain {
    /// Checks the tree and normalises the joint axes.
    ///
    /// # Errors
    /// [`ChainError`] for anything other than a tree of finite numbers with unique names.
    pub fn new(mut joints: Vec<Joint>, frames: Vec<Frame>) -> Result<Self, ChainError> {
        if joints.len() > MAX_JOINTS {
            return Err(ChainError::TooManyJoints {
                count: joints.len(),
            });
        }
        for (index, joint) in joints.iter_mut().enumerate() {
            check_joint(index, joint)?;
        }
        // After all joints: a joint may follow one that comes later.
        for joint in &joints {
            check_mimic(joint, &joints)?;
        }
        for frame in &frames {
            if let Some(joint) = frame.joint.filter(|&j| j >= joints.len()) {
                return Err(ChainError::NoSuchJoint {
                    frame: frame.name.clone(),
                    joint,
                    count: joints.len(),
                });
            }
            check_pose("frame", &frame.name, &frame.pose)?;
        }
        check_unique("joint", joints.iter().map(|j| j.name.as_str()))?;
        check_unique("frame", frames.iter().map(|f| f.name.as_str()))?;
        Ok(Self { joints, frames })
    }

    /// The joints, parents first.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The frames in the order given.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Index of the joint of that name.
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }

    /// Index of the frame of that name.
    pub fn frame_index(&self, name: &str) -> Option<usize> {
        self.frames.iter().position(|f| f.name == name)
    }
}

fn check_joint(index: usize, joint: &mut Joint) -> Result<(), ChainError> {
    if let Some(parent) = joint.parent.filter(|&p| p >= index) {
        return Err(ChainError::ParentOrder {
            joint: joint.name.clone(),
            parent,
        });
    }
    check_pose("joint", &joint.name, &joint.origin)?;
    let length = joint.axis.norm();
    // An axis without a length has no direction; after a division it would be NaN everywhere.
    if !(length.is_finite() && length > 1e-9) {
        return Err(ChainError::Axis {
            joint: joint.name.clone(),
            axis: joint.axis.into(),
        });
    }
    // A unit axis is not divided, so that no rounding enters exact data.
    if (length - 1.0).abs() > 1e-15 {
        joint.axis /= length;
    }
    // Written so that NaN fails as well.
    if joint.lower < joint.upper {
        Ok(())
    } else {
        Err(ChainError::Limits {
            joint: joint.name.clone(),
            lower: joint.lower,
            upper: joint.upper,
        })
    }
}

fn check_mimic(joint: &Joint, joints: &[Joint]) -> Result<(), ChainError> {
    let Some(mimic) = joint.mimic else {
        return Ok(());
    };
    let followed = joints.get(mimic.joint);
    // One level only: a chain of followers would have no slot of a controlled joint.
    let is_free = followed.is_some_and(|other| other.mimic.is_none());
    let moves = mimic.multiplier.is_finite() && mimic.multiplier != 0.0;
    if is_free && moves && mimic.offset.is_finite() {
        return Ok(());
    }
    Err(ChainError::Mimic {
        joint: joint.name.clone(),
        of: mimic.joint,
    })
}

fn check_pose(what: &'static str, name: &str, pose: &Isometry3<f64>) -> Result<(), ChainError> {
    let finite = pose.translation.vector.iter().all(|x| x.is_finite())
        && pose.rotation.coords.iter().all(|x| x.is_finite());
    if finite {
        Ok(())
    } else {
        Err(ChainError::NotFinite {
            what,
            name: name.to_owned(),
        })
    }
}

fn check_unique<'a>(
    what: &'static str,
    names: impl Iterator<Item = &'a str>,
) -> Result<(), ChainError> {
    let mut sorted: Vec<&str> = names.collect();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(ChainError::DuplicateName {
            what,
            name: pair[0].to_owned(),
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joint(name: &str, parent: Option<usize>) -> Joint {
        Joint {
            name: name.into(),
            parent,
            origin: Isometry3::identity(),
            axis: Vector3::new(0.0, 0.0, 2.0),
            kind: JointKind::Revolute,
            lower: -1.0,
            upper: 1.0,
            mimic: None,
        }
    }

    #[test]
    fn a_joint_follows_another_one_that_moves_by_itself() {
        let follows = |joint: usize, multiplier: f64| {
            Some(Mimic {
                joint,
                multiplier,
                offset: 0.0,
            })
        };
        let with = |of_b: Option<Mimic>, of_c: Option<Mimic>| {
            let mut joints = vec![joint("a", None), joint("b", Some(0)), joint("c", Some(1))];
            joints[1].mimic = of_b;
            joints[2].mimic = of_c;
            Chain::new(joints, vec![])
        };
        assert!(with(follows(2, -1.0), None).is_ok());
        for (of_b, of_c) in [
            (follows(1, 1.0), None),
            (follows(2, 1.0), follows(1, 1.0)),
            (follows(7, 1.0), None),
            (follows(0, 0.0), None),
            (follows(0, f64::NAN), None),
        ] {
            let said = with(of_b, of_c).unwrap_err();
            assert!(matches!(said, ChainError::Mimic { .. }), "{said}");
        }
    }

    #[test]
    fn axes_are_normalised_and_branches_allowed() {
        let joints = vec![joint("a", None), joint("b", Some(0)), joint("c", Some(0))];
        let chain = Chain::new(joints, vec![]).unwrap();
        assert_eq!(chain.joints()[2].axis, Vector3::z());
        assert_eq!(chain.joint_index("c"), Some(2));
    }

    #[test]
    fn a_joint_cannot_hang_on_a_later_joint() {
        let error = Chain::new(vec![joint("a", Some(1)), joint("b", None)], vec![]).unwrap_err();
        assert!(error.to_string().contains("'a'"), "{error}");
    }

    #[test]
    fn zero_axes_nan_poses_and_shared_names_are_refused() {
        let mut no_axis = joint("a", None);
        no_axis.axis = Vector3::zeros();
        assert!(matches!(
            Chain::new(vec![no_axis], vec![]),
            Err(ChainError::Axis { .. })
        ));
        let frame = Frame {
            name: "f".into(),
            joint: None,
            pose: Isometry3::translation(f64::NAN, 0.0, 0.0),
        };
        assert!(matches!(
            Chain::new(vec![], vec![frame]),
            Err(ChainError::NotFinite { .. })
        ));
        assert!(matches!(
            Chain::new(vec![joint("a", None), joint("a", None)], vec![]),
            Err(ChainError::DuplicateName { .. })
        ));
    }

    #[test]
    fn nan_limits_are_refused() {
        let mut bad = joint("a", None);
        bad.upper = f64::NAN;
        assert!(matches!(
            Chain::new(vec![bad], vec![]),
            Err(ChainError::Limits { .. })
        ));
    }
}
