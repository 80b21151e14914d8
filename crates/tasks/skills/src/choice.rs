//! The grasp with which an object is picked up.

use grasp::{Candidate, Exclusion, Grasps, first_grasps};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use robocell_task::job::Placement;

use crate::pose::{about, isometry};
use crate::world::World;

/// Candidates that the kinematics may refuse in one decision: each takes 4 to 9 ms, and after 28 ms
/// without a decision the arm holds.
const SEARCHED: usize = 3;
/// Two grasps whose fingers close along the same line and that come from the same side are the
/// same one for a retry (cosine).
const SAME: f64 = 0.99;

/// The answer to the question how to grip an object.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Choice {
    /// The grasp.
    Grasp(Chosen),
    /// There is none.
    None(Exclusion),
    /// The object is not in the cell, or the arm has no gripper.
    Unknown,
}

/// A grasp.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chosen {
    /// The TCP, world frame.
    pub(crate) tcp: Isometry3<f64>,
    /// Distance of the fingers on the way there (m).
    pub(crate) opening_m: f64,
    /// A text for the log where it is not the usual grasp.
    pub(crate) remark: Option<String>,
}

impl World<'_> {
    /// The grasp of `object` after this number of failures: each takes the next candidate.
    pub(crate) fn choose_grasp(&self, object: usize, failures: u32) -> Choice {
        let grasping = &self.setup.grasping;
        let scene = grasping.scene(self.arm, self.observation);
        let Some((gripper, scene)) = grasping.gripper(self.arm).zip(scene) else {
            return Choice::Unknown;
        };
        // The pose in which the wrist is not wound: of equal grasps the nearest to it is taken.
        let tool = self.arm_setup().map(|arm| isometry(&arm.wait));
        // After a failure all are needed, to find the next one.
        let enough = if failures == 0 { 1 } else { usize::MAX };
        let (mut searched, mut reached) = (0, 0);
        let reaches = |tcp: &Isometry3<f64>| {
            // Those that are not searched are not known to be in reach.
            if searched == SEARCHED || reached > failures {
                return false;
            }
            let reaches = grasping.reaches(self.arm, self.joint_positions(), tcp);
            if reaches {
                reached += 1;
            } else {
                searched += 1;
            }
            reaches
        };
        let of = (object, tool.as_ref());
        let found = first_grasps(gripper, &scene, of, enough, reaches);
        match nth(&found, failures) {
            Some(chosen) => Choice::Grasp(Chosen {
                tcp: chosen.tcp,
                opening_m: chosen.opening_m,
                remark: remark(&found, chosen),
            }),
            None => found
                .refusal()
                .map_or(Choice::Unknown, |why| Choice::None(why.clone())),
        }
    }
}

/// The grasp after this number of failures; the first one follows the last.
fn nth(found: &Grasps, failures: u32) -> Option<&Candidate> {
    let mut different: Vec<&Candidate> = Vec::new();
    for candidate in found.candidates.iter().filter(|of| of.excluded.is_none()) {
        if !different.iter().any(|known| is_same(known, candidate)) {
            different.push(candidate);
        }
    }
    let count = different.len();
    (count > 0).then(|| different[failures as usize % count])
}

fn is_same(a: &Candidate, b: &Candidate) -> bool {
    let dot = |axis: Vector3<f64>| (a.tcp.rotation * axis).dot(&(b.tcp.rotation * axis));
    let near = (a.tcp.translation.vector - b.tcp.translation.vector).norm() < 1.0e-3;
    near && dot(Vector3::y()).abs() > SAME && dot(Vector3::z()) > SAME
}

/// The text for the log: of a grasp before which others were excluded.
fn remark(found: &Grasps, chosen: &Candidate) -> Option<String> {
    let mut cheaper = found.candidates.iter().filter(|of| of.cost < chosen.cost);
    let first = cheaper.find_map(|of| Some((of, of.excluded.as_ref()?)))?;
    let name = |of: &Candidate| format!("{}, {}", of.approach.name(), of.depth.name());
    let (best, why) = first;
    Some(format!("{}; {}: {why}", name(chosen), name(best)))
}

/// The frame that follows an object: its centre, and its turn about the vertical.
pub(crate) fn frame(at: &Placement) -> Isometry3<f64> {
    let turn: UnitQuaternion<f64> = about(Vector3::z(), at.yaw);
    Isometry3::from_parts(Translation3::from(at.position), turn)
}
