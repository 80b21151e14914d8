//! The published numbers of NVIDIA's own unit test for these formulas (cuMotion
//! 1.1): one state in full, and what wrong formulas would change.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unreadable_literal,
    clippy::needless_range_loop,
    clippy::unnecessary_to_owned,
    clippy::many_single_char_names,
    reason = "a test fails by panicking, says what it skips, and compares with published digits"
)]

use crate::common;

use common::{Files, panda};
use nalgebra::{Isometry3, Vector3};
use rmp::{MotionState, Obstacle, Outcome, RmpFlow, TargetId};

const STATE: [f64; 7] = [0.0, -1.3, 0.0, -2.87, 0.0, 2.0, 0.75];

/// Published digits are rounded.
const TOLERANCE: f64 = 1e-3;

fn scene(files: &Files) -> (RmpFlow, TargetId) {
    let mut flow = files.flow(8);
    let frame = ["right_gripper", "panda_right_gripper"]
        .into_iter()
        .find(|name| files.chain.frame_index(name).is_some())
        .expect("the tool frame of the published test");
    let id = flow.add_target_frame(frame).unwrap();
    let obstacles = flow.obstacles_mut();
    obstacles
        .add(Obstacle::sphere(Vector3::new(0.3, 0.0, 0.6), 0.05))
        .unwrap();
    obstacles
        .add(Obstacle::cuboid(
            Isometry3::translation(0.4, 0.0, 0.2),
            Vector3::repeat(0.1),
        ))
        .unwrap();
    flow.set_position_target(id, Some(Vector3::new(0.8, 0.0, 0.35)))
        .unwrap();
    (flow, id)
}

fn assert_golden_state(files: &Files) {
    const ACCELERATION: [f64; 7] = [
        -0.149459, -24.1595, -0.167684, -40.4155, 0.0096364, -16.815, 0.0494,
    ];
    const FORCE: [f64; 7] = [
        -61991.6877,
        -7534653.33,
        -69744.7161,
        -13006465.844,
        4135.46402,
        -5397935.177,
        20835.0061,
    ];
    const DIAGONAL: [f64; 7] = [
        775.650655, 3073.90049, 754.118668, 10517.9771, 136.706724, 1591.13314, 105.208768,
    ];
    const ROW_1: [f64; 7] = [
        775.650655,
        -14.3174561,
        686.355989,
        336.982731,
        105.714143,
        125.344953,
        -155.738298,
    ];
    const ROW_4: [f64; 7] = [
        336.982731,
        -907.944895,
        384.611192,
        10517.9771,
        -27.019779,
        3770.55119,
        -110.482394,
    ];
    let (mut flow, _) = scene(files);
    let root = flow.evaluate(&STATE, &[0.0; 7]).unwrap().clone();
    for i in 0..7 {
        assert!((root.metric[(i, i)] - DIAGONAL[i]).abs() < TOLERANCE, "{i}");
        assert!((root.metric[(0, i)] - ROW_1[i]).abs() < TOLERANCE, "{i}");
        assert!((root.metric[(3, i)] - ROW_4[i]).abs() < TOLERANCE, "{i}");
        // Published with nine digits.
        let rounding = TOLERANCE + FORCE[i].abs() * 2e-9;
        assert!(
            (root.force[i] - FORCE[i]).abs() < rounding,
            "{i}: {}",
            root.force[i]
        );
    }
    let (a, outcome) = flow.resolve_exact();
    assert_eq!(outcome, Outcome::Shortened);
    let norm = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((norm - 50.0).abs() < 1e-9, "{norm}");
    for i in 0..7 {
        assert!((a[i] - ACCELERATION[i]).abs() < TOLERANCE, "{i}: {}", a[i]);
    }
}

#[test]
fn the_published_state_is_met_with_our_own_robot() {
    assert_golden_state(&panda());
}

#[test]
fn without_obstacles_and_targets_the_published_norm_is_met() {
    let mut flow = panda().flow(0);
    flow.evaluate(&STATE, &[0.0; 7]).unwrap();
    let (a, outcome) = flow.resolve_exact();
    let norm = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert_eq!(outcome, Outcome::Free);
    assert!((norm - 0.652_816_77).abs() < 1e-5, "{norm}");
}

/// The published 60 s motion; its digits are not part of this repository.
fn rollout(files: &Files) -> Vec<f64> {
    let (mut flow, id) = scene(files);
    let mut state = MotionState::at_rest(&[0.0; 7]);
    for k in 0..6000 {
        let y = 0.5 * libm::sin(0.5 * 0.01 * f64::from(k));
        flow.set_position_target(id, Some(Vector3::new(0.8, y, 0.35)))
            .unwrap();
        let report = flow.step_exact(&mut state, 0.01).unwrap();
        assert_ne!(report.outcome, Outcome::Singular, "step {k}");
        assert!(report.clearance.unwrap().distance > 0.0, "step {k}");
    }
    state.positions
}

#[test]
fn the_published_motion_is_stable_and_repeats_bit_for_bit() {
    let end = rollout(&panda());
    assert_eq!(end, rollout(&panda()));
    for (q, joint) in end
        .iter()
        .zip(panda().limits().lower.iter().zip(&panda().limits().upper))
    {
        assert!(q > joint.0 && q < joint.1, "{end:?}");
    }
}
