//! The shapes of a tool in the frame of its TCP.

use cell_model::Robot;
use nalgebra::{Isometry3, Translation3, Vector3};

use crate::solid::Solid;

/// Length of the way to a grasp that is checked (m).
const WAY_M: f64 = 0.1;

/// Share of the grip distance of a cup at which it stops: the arm stops within 4 mm.
const GAP_SHARE: f64 = 0.3;

/// A tool that grips.
#[derive(Clone)]
pub enum Gripper {
    /// Two fingers.
    Fingers(Hand),
    /// A suction cup.
    Cup(Cup),
}

/// A hand with two fingers that close along the y axis of the TCP frame.
#[derive(Clone)]
pub struct Hand {
    /// Width of the open hand (m).
    pub open_width_m: f64,
    /// How far the finger tips reach beyond the TCP, and the pads before it (m).
    pub(crate) tip_m: f64,
    /// The hand without its fingers.
    pub(crate) palm: Solid,
    /// The closed fingers, and how far each moves by a metre of width.
    pub(crate) fingers: [(Solid, Vector3<f64>); 2],
}

/// A suction cup.
#[derive(Clone)]
pub struct Cup {
    /// Radius of the rim (m).
    pub radius_m: f64,
    /// Gap to the face at which the cup is switched on (m): a cup that presses is torn off by the
    /// force of the arm when it attaches.
    pub gap_m: f64,
    /// Direction out of the cup, in the TCP frame.
    pub(crate) axis: Vector3<f64>,
    /// The tool above the cup.
    pub(crate) body: Solid,
}

impl Gripper {
    /// The tool of `robot`; `None` for one without a gripper.
    pub fn of(robot: &Robot) -> Option<Self> {
        match (&robot.gripper, &robot.suction) {
            (Some(_), _) => Hand::of(robot).map(Self::Fingers),
            (None, Some(suction)) => Some(Self::Cup(Cup {
                radius_m: suction.cup_radius,
                gap_m: GAP_SHARE * suction.grip_distance,
                axis: suction.axis,
                body: body_of_tool(robot, &home(robot))?,
            })),
            (None, None) => None,
        }
    }
}

impl Gripper {
    /// Radius of a ball about the TCP that contains the tool on its way (m).
    pub(crate) fn radius(&self) -> f64 {
        let solid = match self {
            Self::Fingers(hand) => {
                let fingers = hand.fingers.iter().map(|(solid, per_width)| {
                    solid.radius() + hand.open_width_m * per_width.norm()
                });
                fingers.fold(hand.palm.radius(), f64::max)
            }
            Self::Cup(cup) => cup.body.radius(),
        };
        solid + WAY_M
    }
}

impl Hand {
    /// The hand of `robot`; `None` for one without fingers.
    pub fn of(robot: &Robot) -> Option<Self> {
        let gripper = robot.gripper.as_ref()?;
        let of_width = |width: f64| {
            let mut positions = home(robot);
            for joint in gripper.finger_joints {
                *positions.get_mut(joint)? = 0.5 * width;
            }
            Some(positions)
        };
        // A width of 1 m is beyond the limits of the joints: only the difference of the poses is
        // used, which is linear in the width.
        let (closed, wide) = (of_width(0.0)?, of_width(1.0)?);
        let finger = |joint: usize| {
            let (at, apart) = (
                link_in_tcp(robot, joint + 1, &closed)?,
                link_in_tcp(robot, joint + 1, &wide)?,
            );
            let mut solid = Solid::default();
            for part in &robot.links.get(joint + 1)?.shapes {
                solid.add(&part.shape, &(at * part.pose));
            }
            Some((solid, apart.translation.vector - at.translation.vector))
        };
        let [left, right] = gripper.finger_joints;
        let fingers = [finger(left)?, finger(right)?];
        let (_, tip_m) = fingers[0].0.extent(&Isometry3::identity(), &Vector3::z());
        Some(Self {
            open_width_m: gripper.max_width,
            tip_m,
            palm: body_of_tool(robot, &closed)?,
            fingers,
        })
    }

    /// The poses of both fingers for a TCP at `tcp` and a width (m).
    pub(crate) fn fingers_at(
        &self,
        tcp: &Isometry3<f64>,
        width_m: f64,
    ) -> impl Iterator<Item = (&Solid, Isometry3<f64>)> {
        let tcp = *tcp;
        let at = move |finger: &Vector3<f64>| tcp * Translation3::from(finger * width_m);
        self.fingers
            .iter()
            .map(move |(solid, per_width)| (solid, at(per_width)))
    }
}

/// Positions of all joints at the start of a run.
fn home(robot: &Robot) -> Vec<f64> {
    robot.with_arm_positions(&robot.home())
}

/// Pose of a link in the frame of the TCP.
fn link_in_tcp(robot: &Robot, link: usize, positions: &[f64]) -> Option<Isometry3<f64>> {
    let tcp = robot.frame_pose(robot.tcp_frame, positions)?;
    let poses = robot.link_poses(positions);
    Some(tcp.inverse() * poses.get(link)?)
}

/// The link that has the TCP.
fn body_of_tool(robot: &Robot, positions: &[f64]) -> Option<Solid> {
    let frame = robot.chain.frames().get(robot.tcp_frame)?;
    let link = frame.joint.map_or(0, |joint| joint + 1);
    let at = link_in_tcp(robot, link, positions)?;
    let mut solid = Solid::default();
    for part in &robot.links.get(link)?.shapes {
        solid.add(&part.shape, &(at * part.pose));
    }
    Some(solid)
}
