//! Whether an arm is able to do what a job asks of it, decided before the first decision.
//!
//! A job that can only fail shall not begin: it would move an arm, retry, and end a minute
//! later with a reason that names a symptom. So every way in which a job is made (files,
//! code, Python; in four processes, in one, in `eval`) asks [`lacks`], and refuses the job
//! with [`refusal`]. What may change while a job runs, as the position of an object, is
//! never a reason to refuse: it is a warning.
//!
//! A refusal has to be certain. Kinematics are searched from many starts, for any turn of
//! the tool about the vertical, without obstacles, and with a tolerance wider than that of
//! a motion.

use std::f64::consts::FRAC_PI_4;
use std::fmt;

use cell_model::{ArmSpec, Cell};
use nalgebra::{Isometry3, Vector3};
use plan::Found;

use crate::geometry::rotation;
use crate::setup::{ArmSetup, ObjectSetup, Setup, Tool};

/// Turns of the tool about the vertical that are tried, `FRAC_PI_4` apart.
const TURNS: u32 = 8;
/// A motion ends within 4 mm and 0.05 rad of its target at best, one of a long way within
/// 20 mm.
const NEAR_M: f64 = 0.01;
const NEAR_RAD: f64 = 0.1;
/// With fewer joints no arm turns its tool at will, and the search is for a whole pose.
const JOINTS_OF_A_POSE: usize = 6;

/// What a job asks of an arm.
#[derive(Clone, Copy, Debug)]
pub enum Need<'n> {
    /// To pick up this object; any, where a job finds out later which.
    Grip(Option<&'n ObjectSetup>),
    /// To bring its tool, pointing down, to one of these points (m, world frame).
    Reach(&'n ArmSpec, &'n [Vector3<f64>]),
}

/// What an arm lacks for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lack {
    /// Nothing on it grips.
    Gripper,
    /// Every side of the object is wider than the hand opens.
    Width {
        /// The narrowest side (m).
        side_m: f64,
        /// Width of the open hand (m).
        opens_m: f64,
    },
    /// Its joints do not bring the tool there.
    Reach {
        /// How far off the tool stays at best (m).
        off_m: f64,
        /// How far it is turned away from pointing down there (rad).
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

/// What `arm` lacks for `need`; none where it is able to do it, or where that is not certain.
pub fn lacks(arm: &ArmSetup, need: Need<'_>) -> Option<Lack> {
    match (need, arm.tool) {
        (Need::Grip(_), Tool::None) => Some(Lack::Gripper),
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

/// One line that refuses a job: what is asked of which arm, what it lacks, what to do.
pub fn refusal(arm: &str, object: Option<&str>, lack: Lack) -> String {
    let what = object.map_or_else(|| "pick".to_owned(), |object| format!("grip '{object}'"));
    let advice = match lack {
        Lack::Gripper => "use a robot with fingers or suction, or another arm",
        Lack::Width { .. } => "use another object, a wider hand, or suction",
        Lack::Reach { .. } => "move it nearer, or the base of the arm",
    };
    format!("arm '{arm}' cannot {what}: it {lack}; {advice}")
}

/// What is probably not meant: objects that a file picks and that are out of reach at the
/// start. They may be moved, so the job is not refused.
pub(crate) fn far_picks(cell: &Cell, setup: &Setup) -> Vec<String> {
    let warning = |(arm, object): (usize, usize)| {
        let (of, spec) = (setup.arms.get(arm)?, cell.arms.get(arm)?);
        let (found, known) = (cell.objects.get(object)?, setup.objects.get(object)?);
        if found.parked {
            return None;
        }
        let [x, y, z] = found.pose.translation.vector.into();
        let grip = Vector3::new(x, y, z + of.tool.grasp_height(known));
        let off = (grip - of.base).xy().norm();
        let why = if of.reaches(grip) {
            let lack = lacks(of, Need::Reach(spec, &[grip]))?;
            format!("it {lack}")
        } else {
            let reach = of.reach_m;
            format!("it reaches {reach:.2} m of {off:.2} m")
        };
        // A line of the trace has room for 160 bytes.
        let (arm, object) = (&of.name, &known.name);
        Some(format!(
            "{arm} cannot pick {object} at [{x:.2}, {y:.2}, {z:.2}]: {why}; move it nearer"
        ))
    };
    setup.picks.all().into_iter().filter_map(warning).collect()
}

/// How near the tool of `spec` gets to the nearest of `points`; none where it gets there.
fn unreached(spec: &ArmSpec, tool: Tool, points: &[Vector3<f64>]) -> Option<Lack> {
    let robot = &spec.robot;
    if robot.arm_joints.len() < JOINTS_OF_A_POSE || points.is_empty() {
        return None;
    }
    // A robot whose files contradict each other is refused by its controller.
    let mut flow = robot.motion_policies(0).ok()?;
    let frame = flow.add_target_frame(robot.tcp_frame_name()).ok()?;
    let limits = robot.limits();
    let mut kinematics = plan::Tool::new(&mut flow, frame, &limits);
    let near = [&spec.home[..], &robot.default_joint_positions[..]];
    let mut best: Option<Found> = None;
    for point in points {
        for turn in 0..TURNS {
            let down = rotation(tool.down(f64::from(turn) * FRAC_PI_4));
            let goal = spec.base.inverse() * Isometry3::from_parts((*point).into(), down);
            let found = kinematics.search(&near, &goal)?;
            if found.off_m < NEAR_M && found.off_rad < NEAR_RAD {
                return None;
            }
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
