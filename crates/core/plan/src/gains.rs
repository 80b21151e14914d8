//! Gains of motion policies while a path leads the arm.

use rmp::{CollisionParameters, CspaceTargetParameters, RmpFlowParameters};

/// Distance within which obstacles push (m). The path is free, so they are a reflex; an arm
/// that is kept at half a metre gets through no opening: with the gains of the tuning the
/// Panda follows 473 of 664 paths (ADR 0019).
const REACH_M: f64 = 0.03;
/// Factor on the weight of obstacles.
// With their full weight obstacles would compete with the path, which is free (ADR 0019).
const REFLEX: f64 = 0.2;
/// Factor on the weight of the posture. The path is one in joint space, and where it passes a
/// straight elbow the pose of the tool alone would hold the arm back: with a factor of 10 the
/// UR5 follows 631 of 689 paths (ADR 0019).
const POSTURE: f64 = 200.0;

/// Gains with which an arm follows a path, made of the gains of its tuning. They were found
/// with the problems of `MotionBenchMaker` (`motion_bench --execute`), of which none ended in
/// a contact.
pub fn led(tuning: &RmpFlowParameters) -> (CspaceTargetParameters, CollisionParameters) {
    let (mut posture, mut collision) = (tuning.cspace_target, tuning.collision);
    posture.metric_scalar *= POSTURE;
    collision.metric_scalar *= REFLEX;
    collision.metric_modulation_radius = collision.metric_modulation_radius.min(REACH_M);
    (posture, collision)
}
