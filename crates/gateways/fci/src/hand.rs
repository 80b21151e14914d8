//! Flange and hand of the maker (`franka_description`, `robots/common` and
//! `end_effectors/franka_hand`). The mass of the hand is a value of the state: a client adds it to
//! the last link of its model.

use cell_model::{Link, Robot};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

/// Distance of the flange from joint 7 along its axis (m).
pub(crate) const FLANGE_M: f64 = 0.107;
/// Distance of the point where the fingers meet from the flange (m).
const FINGERS_M: f64 = 0.1034;

/// Mass (kg), centre of mass (m) and inertia about it (kg·m², column by column) in the frame of
/// the flange.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hand {
    pub(crate) mass: f64,
    pub(crate) center: [f64; 3],
    pub(crate) inertia: [f64; 9],
}

impl Hand {
    /// Of `robot`; without mass where it has none.
    pub(crate) fn of(robot: &Robot) -> Self {
        let Some((_, hand)) = split(robot) else {
            return Self::default();
        };
        let rotation = turn().to_rotation_matrix();
        let inertia = rotation.matrix() * hand.inertia * rotation.matrix().transpose();
        let center = rotation * hand.center_of_mass;
        Self {
            mass: hand.mass,
            center: center.into(),
            inertia: std::array::from_fn(|index| inertia[index]),
        }
    }
}

/// The nominal end effector in the frame of the flange: between the fingers, or the flange.
pub(crate) fn nominal(robot: &Robot) -> Isometry3<f64> {
    if robot.gripper.is_some() {
        Isometry3::from_parts(Vector3::new(0.0, 0.0, FINGERS_M).into(), turn())
    } else {
        Isometry3::identity()
    }
}

/// The last link of the arm without the hand; `None` where the robot has no such hand.
pub(crate) fn last_link(robot: &Robot) -> Option<Link> {
    split(robot).map(|(link, _)| link)
}

/// The hand is turned by 45° on the flange.
fn turn() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -std::f64::consts::FRAC_PI_4)
}

/// The last link of the arm without the hand, and the hand.
fn split(robot: &Robot) -> Option<(Link, Link)> {
    robot.gripper.as_ref()?;
    let link = robot.links.get(robot.arm_joints.last()? + 1)?;
    let hand = Link {
        name: String::new(),
        mass: 0.73,
        center_of_mass: Vector3::new(-0.01, 0.0, 0.03),
        inertia: Matrix3::from_diagonal(&Vector3::new(0.001, 0.0025, 0.0017)),
        shapes: Vec::new(),
    };
    let pose = Isometry3::from_parts(Vector3::new(0.0, 0.0, FLANGE_M).into(), turn());
    Some((link.without(&hand, &pose)?, hand))
}
