//! Whether an arm is able to do a job, decided before the first decision.
//!
//! A job that can only fail must not start: it would move an arm, retry, and end a minute later
//! with a reason that names a symptom (ADR 0026). So every way to make a job (files, code,
//! Python; in four processes, in one, in `eval`) calls [`lacks`], and refuses the job with
//! [`refusal`]. Conditions that may change while a job runs, such as the position of an object,
//! are never a reason to refuse: they are warnings.
//!
//! A refusal has to be certain. Kinematics are searched from many starts, for any turn of the
//! tool about the vertical, without obstacles, and with a tolerance wider than that of a
//! motion. A change must keep it so: a job that is refused wrongly cannot run at all, while one
//! that is accepted wrongly still ends with a named reason.

use std::f64::consts::FRAC_PI_4;
use std::fmt;

use cell_model::ArmSpec;
use nalgebra::{Isometry3, Vector3};
use plan::Found;

use crate::geometry::rotation;
use crate::setup::arm::{ArmSetup, Tool};
use crate::setup::object::ObjectSetup;

/// Turns of the tool about the vertical that are tried, `FRAC_PI_4` apart.
const TURNS: u32 = 8;
/// Tolerance of the search (m, rad): wider than that of a motion, which ends within 4 mm and
/// 0.05 rad of its target, or within 20 mm after a long way.
const NEAR_M: f64 = 0.01;
const NEAR_RAD: f64 = 0.1;
/// With fewer joints no arm turns its tool at will, and the search is for a whole pose: no
/// answer.
const JOINTS_OF_A_POSE: usize = 6;

/// A requirement of a job.
#[derive(Clone, Copy, Debug)]
pub enum Need<'n> {
    /// To pick up this object; `None` if the job chooses the object later.
    Grip(Option<&'n ObjectSetup>),
    /// To bring its tool, pointing down, to one of these points (m, world frame).
    Reach(&'n ArmSpec, &'n [Vector3<f64>]),
}

/// The reason for which an arm cannot meet a requirement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lack {
    /// The arm has no gripper.
    Gripper,
    /// Every side of the object is wider than the hand opens.
    Width {
        /// The narrowest side (m).
        side_m: f64,
        /// Width of the open hand (m).
        opens_m: f64,
    },
    /// Its joints cannot bring the tool there.
    Reach {
        /// Smallest distance of the tool from the point (m).
        off_m: f64,
        /// Angle of the tool from pointing down there (rad).
        off_rad: f64,
    },
}

impl Lack {
    /// Stable name of the failure of a job.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Gripper => "arm_has_no_gripper",
            Self::Width { .. } => "object_too_wide",
            Self::Reach { .. } => "place_out_of_reach",
        }
    }
}

impl fmt::Display for Lack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gripper => f.write_str("has no gripper"),
            Self::Width { side_m, opens_m } => write!(
                f,
                "opens its hand {opens_m:.3} m wide, and the narrowest side is {side_m:.3} m"
            ),
            Self::Reach { off_m, .. } if *off_m >= NEAR_M => {
                write!(f, "gets no nearer than {off_m:.3} m")
            }
            Self::Reach { off_rad, .. } => write!(
                f,
                "gets there only with its tool turned {:.0} degrees away",
                off_rad.to_degrees()
            ),
        }
    }
}

/// The lack of `arm` for `need`; `None` if it is able to do it, or if that is not certain.
pub fn lacks(arm: &ArmSetup, need: Need<'_>) -> Option<Lack> {
    match (need, arm.tool) {
        (Need::Grip(_), Tool::None) => Some(Lack::Gripper),
        // Suction holds any flat side, and an object that is chosen later is unknown: nothing
        // to refuse.
        (Need::Grip(None), _) | (Need::Grip(_), Tool::Suction) => None,
        (Need::Grip(Some(object)), Tool::Fingers { open_width_m, .. }) => {
            (object.narrowest_m > open_width_m).then_some(Lack::Width {
                side_m: object.narrowest_m,
                opens_m: open_width_m,
            })
        }
        (Need::Reach(spec, points), _) => unreached(spec, arm.tool, points),
    }
}

/// One line that refuses a job: the requirement, the arm, its lack, and advice.
pub fn refusal(arm: &str, object: Option<&str>, lack: Lack) -> String {
    let what = object.map_or_else(|| "pick".to_owned(), |object| format!("grip '{object}'"));
    let advice = match lack {
        Lack::Gripper => "use a robot with fingers or suction, or another arm",
        Lack::Width { .. } => "use another object, a wider hand, or suction",
        Lack::Reach { .. } => "move it nearer, or the base of the arm",
    };
    format!("arm '{arm}' cannot {what}: it {lack}; {advice}")
}

/// How near the tool of `spec` gets to the nearest of `points`; `None` if it gets there.
fn unreached(spec: &ArmSpec, tool: Tool, points: &[Vector3<f64>]) -> Option<Lack> {
    let robot = &spec.robot;
    if robot.arm_joints.len() < JOINTS_OF_A_POSE || points.is_empty() {
        return None;
    }
    // A robot whose files contradict each other is refused by its controller, with a better
    // reason.
    let mut flow = robot.motion_policies(0).ok()?;
    let frame = flow.add_target_frame(robot.tcp_frame_name()).ok()?;
    let limits = robot.limits();
    // Both the cell's and the robot's own pose are starts: an arm far from one may be near the
    // other.
    let mut kinematics = plan::Tool::new(&mut flow, frame, &limits);
    let near = [&spec.home[..], &robot.default_joint_positions[..]];
    let mut best: Option<Found> = None;
    for point in points {
        for turn in 0..TURNS {
            let down = rotation(tool.down(f64::from(turn) * FRAC_PI_4));
            let goal = spec.base.inverse() * Isometry3::from_parts((*point).into(), down);
            let found = kinematics.search(&near, &goal)?;
            // One point and one turn are enough: the job may choose among them.
            if found.off_m < NEAR_M && found.off_rad < NEAR_RAD {
                return None;
            }
            // Metres and radians are added: 10 mm and 10 mrad off are equally far for this
            // message.
            let off = |found: &Found| found.off_m + found.off_rad;
            if best.as_ref().is_none_or(|best| off(&found) < off(best)) {
                best = Some(found);
            }
        }
    }
    best.map(|found| Lack::Reach {
        off_m: found.off_m,
        off_rad: found.off_rad,
    })
}
