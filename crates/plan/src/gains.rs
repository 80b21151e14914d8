//! Gains of motion policies that are led along a path.

use rmp::{CollisionParameters, CspaceTargetParameters, RmpFlowParameters};

/// Obstacles push within this distance only (m): the path is free, so they are a reflex, and
/// an arm that they keep at half a metre gets through no opening.
const REACH_M: f64 = 0.03;
/// Of the weight of obstacles.
const REFLEX: f64 = 0.2;
/// Of the weight of the posture: the path is one in joint space, and where it passes a
/// straight elbow the pose of the tool alone would not lead through.
const POSTURE: f64 = 200.0;

/// Gains with which an arm follows a path, from those it has: found with the problems of
/// `MotionBenchMaker` (`motion_bench --execute`), none of which ended in a contact.
pub fn led(tuning: &RmpFlowParameters) -> (CspaceTargetParameters, CollisionParameters) {
    let (mut posture, mut collision) = (tuning.cspace_target, tuning.collision);
    posture.metric_scalar *= POSTURE;
    collision.metric_scalar *= REFLEX;
    collision.metric_modulation_radius = collision.metric_modulation_radius.min(REACH_M);
    (posture, collision)
}
