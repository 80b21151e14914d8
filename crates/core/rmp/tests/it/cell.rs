//! What the limits promise: no command violates velocity, acceleration or jerk as
//! physics counts them, no joint leaves its range, no tick allocates.

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

use cell_rt::alloc::count;
use common::{Files, Random, panda, ur10};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rmp::{MAX_CARRIED, MotionState, Obstacle, ObstacleId, Outcome, RmpFlow, TargetId};

const DT: f64 = 1e-3;

fn crowded(files: &Files, frame: &str, seed: u64) -> (RmpFlow, TargetId) {
    let mut flow = files.flow(10);
    let mut random = Random(seed);
    while flow.obstacles().len() < 10 {
        let at = Vector3::new(
            random.between(0.2, 0.9),
            random.between(-0.6, 0.6),
            random.between(0.0, 0.9),
        );
        flow.obstacles_mut()
            .add(Obstacle::sphere(at, 0.04))
            .unwrap();
    }
    let id = flow.add_target_frame(frame).unwrap();
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.1, 0.0);
    flow.set_orientation_target(id, Some(down)).unwrap();
    (flow, id)
}

fn assert_no_violation(files: &Files, frame: &str, seed: u64) {
    let (mut flow, id) = crowded(files, frame, seed);
    let limits = files.limits();
    let mut state = MotionState::at_rest(&flow.posture().to_vec());
    let mut random = Random(seed + 77);
    for tick in 0..8000 {
        if tick % 800 == 0 {
            // Far and near, within reach and not: jumps of the target are the worst.
            let at = Vector3::from_fn(|_, _| random.between(-1.0, 1.0));
            flow.set_position_target(id, Some(at)).unwrap();
        }
        let before = state.clone();
        let report = flow.step_cell(&mut state, &limits, DT).unwrap();
        assert_ne!(report.outcome, Outcome::Singular, "tick {tick}");
        assert_eq!(report.clips.conflict, 0, "tick {tick}");
        common::assert_within_limits(&before, &state, &limits);
    }
}

#[test]
fn jumping_targets_violate_no_limit() {
    for seed in 1..5 {
        assert_no_violation(&panda(), "panda_hand", seed);
        assert_no_violation(&ur10(), "suction_tip", seed);
    }
}

#[test]
fn a_reachable_target_is_reached_within_the_limits() {
    let files = panda();
    let mut flow = files.flow(0);
    let id = flow.add_target_frame("panda_hand").unwrap();
    let target = Vector3::new(0.5, 0.2, 0.4);
    flow.set_position_target(id, Some(target)).unwrap();
    let limits = files.limits();
    let mut state = MotionState::at_rest(&flow.posture().to_vec());
    for _ in 0..5000 {
        flow.step_cell(&mut state, &limits, DT).unwrap();
    }
    let pose = flow.target_frame_pose(id).unwrap();
    assert!((pose.translation.vector - target).norm() < 0.01);
}

/// Seconds until the hand is within 5 mm of a target and stays, in 40 s; `None`: never.
fn settling(files: &Files, frame: &str, (acceleration, jerk): (f64, f64)) -> Option<f64> {
    let mut flow = files.flow(0);
    let id = flow.add_target_frame(frame).unwrap();
    let start = MotionState::at_rest(&flow.posture().to_vec());
    let mut goal = start.positions.clone();
    goal.iter_mut()
        .zip([0.4, -0.2, 0.3, 0.25, -0.4, 0.3])
        .for_each(|(q, by)| *q += by);
    let goal = flow.target_frame_pose_at(id, &goal).unwrap().unwrap();
    flow.set_position_target(id, Some(goal.translation.vector))
        .unwrap();
    flow.set_orientation_target(id, Some(goal.rotation))
        .unwrap();
    let mut limits = files.limits();
    limits.acceleration.fill(acceleration);
    limits.jerk.fill(jerk);
    let mut state = start;
    let mut near_since = Some(0);
    for tick in 0..40_000 {
        flow.step_cell(&mut state, &limits, DT).unwrap();
        let at = flow.target_frame_pose(id).unwrap().translation.vector;
        if (at - goal.translation.vector).norm() > 0.005 {
            near_since = None;
        } else {
            near_since = near_since.or(Some(tick));
        }
    }
    near_since.map(|tick| f64::from(tick) * DT)
}

#[test]
fn an_arm_whose_jerk_limit_is_low_is_slow_but_does_not_swing() {
    // A Unitree G1 with 120 and 1200 swung 0.4 m about its target; below a ratio of 20 1/s
    // so did every arm.
    for limits in [(120.0, 1200.0), (12.0, 500.0), (12.0, 60.0), (2.0, 4.0)] {
        for (files, frame) in [(panda(), "panda_hand"), (ur10(), "suction_tip")] {
            let settled = settling(&files, frame, limits);
            assert!(settled.is_some_and(|s| s < 30.0), "{limits:?}: {settled:?}");
        }
    }
    let fast = settling(&panda(), "panda_hand", (12.0, 6000.0));
    assert!(fast.is_some_and(|s| s < 2.0), "{fast:?}");
}

#[test]
fn no_joint_exceeds_the_velocity_cap_of_the_tuning() {
    let mut files = panda();
    files.parameters.joint_velocity_cap.max_velocity = 0.6;
    // As weak as it may be: the bound does not depend on the leaf.
    files.parameters.joint_velocity_cap.metric_weight = 1e-9;
    files.parameters.joint_velocity_cap.velocity_damping_region = 0.1;
    let (mut flow, id) = crowded(&files, "panda_hand", 2);
    let limits = files.limits();
    let mut state = MotionState::at_rest(&flow.posture().to_vec());
    let mut fastest: f64 = 0.0;
    for tick in 0..4000 {
        let side = if tick / 1000 % 2 == 0 { 0.6 } else { -0.6 };
        flow.set_position_target(id, Some(Vector3::new(0.3, side, 0.5)))
            .unwrap();
        flow.step_cell(&mut state, &limits, DT).unwrap();
        fastest = state.velocities.iter().fold(fastest, |f, v| f.max(v.abs()));
    }
    assert!(fastest < 0.6 + 1e-9, "{fastest}");
    assert!(fastest > 0.55, "the cap was never reached: {fastest}");
}

/// Joint positions after 3 s towards two targets, of which the second has `weight` times
/// the gains of the first and may be removed after a second.
fn two_frames(weight: f64, removed: bool) -> (MotionState, [Vector3<f64>; 2]) {
    let files = panda();
    let mut flow = files.flow(0);
    let hand = flow.add_target_frame("panda_hand").unwrap();
    let elbow = flow.add_target_frame("panda_link4").unwrap();
    let (mut target, axis) = (files.parameters.target, files.parameters.axis_target);
    target.max_metric_scalar *= weight;
    target.min_metric_scalar *= weight;
    flow.set_target_gains(elbow, target, axis).unwrap();
    flow.set_position_target(hand, Some(Vector3::new(0.5, 0.2, 0.5)))
        .unwrap();
    // Not reachable while the hand is at its target.
    flow.set_position_target(elbow, Some(Vector3::new(-0.3, 0.4, 0.6)))
        .unwrap();
    let limits = files.limits();
    let mut state = MotionState::at_rest(&flow.posture().to_vec());
    for tick in 0..4000 {
        if removed && tick == 1000 {
            assert!(flow.remove_target_frame(elbow));
            assert!(!flow.remove_target_frame(elbow));
        }
        flow.step_cell(&mut state, &limits, DT).unwrap();
    }
    let at = |id| {
        flow.target_frame_pose(id)
            .map_or_else(Vector3::zeros, |p| p.translation.vector)
    };
    let ends = [at(hand), at(elbow)];
    assert_eq!(flow.target_frame_pose(elbow).is_none(), removed);
    (state, ends)
}

#[test]
fn two_frames_have_targets_with_gains_of_their_own() {
    let hand = Vector3::new(0.5, 0.2, 0.5);
    let elbow = Vector3::new(-0.3, 0.4, 0.6);
    let (_, weak) = two_frames(1e-3, false);
    let (_, strong) = two_frames(30.0, false);
    assert!((weak[0] - hand).norm() < 0.02, "{weak:?}");
    assert!(
        (strong[1] - elbow).norm() < (weak[1] - elbow).norm() - 0.1,
        "{strong:?}"
    );
    // Removed, it pulls no more.
    let (_, removed) = two_frames(30.0, true);
    assert!((removed[0] - hand).norm() < 0.01, "{removed:?}");
}

#[test]
fn gains_that_are_none_are_refused_and_change_nothing() {
    let files = panda();
    let mut flow = files.flow(0);
    let id = flow.add_target_frame("panda_hand").unwrap();
    let (mut target, axis) = (files.parameters.target, files.parameters.axis_target);
    target.accel_p_gain = f64::NAN;
    let refused = flow
        .set_target_gains(id, target, axis)
        .unwrap_err()
        .to_string();
    assert!(refused.contains("accel_p_gain"), "{refused}");
    let (posture, mut collision) = (files.parameters.cspace_target, files.parameters.collision);
    collision.metric_modulation_radius = 0.0;
    let refused = flow.set_gains(posture, collision).unwrap_err().to_string();
    assert!(refused.contains("metric_modulation_radius"), "{refused}");
    flow.set_target_gains(id, files.parameters.target, axis)
        .unwrap();
    flow.set_gains(posture, files.parameters.collision).unwrap();
}

#[test]
fn no_tick_allocates() {
    let files = panda();
    let (mut flow, id) = crowded(&files, "panda_hand", 3);
    let limits = files.limits();
    let mut state = MotionState::at_rest(&flow.posture().to_vec());
    let mut exact = state.clone();
    let posture = flow.posture().to_vec();
    let before = count();
    for tick in 0..2000_u32 {
        let y = 0.4 * libm::sin(0.01 * f64::from(tick));
        flow.set_position_target(id, Some(Vector3::new(0.5, y, 0.4)))
            .unwrap();
        flow.set_posture(&posture).unwrap();
        let set = flow.obstacles_mut();
        set.set_pose(ObstacleId(1), Isometry3::translation(0.6, y, 0.3))
            .unwrap();
        set.set_enabled(ObstacleId(2), tick % 2 == 0).unwrap();
        if tick % 100 == 0 {
            flow.carry(id, &[(Vector3::zeros(), 0.02); MAX_CARRIED])
                .unwrap();
        }
        if tick % 100 == 50 {
            flow.drop_carried();
        }
        flow.step_cell(&mut state, &limits, DT).unwrap();
        flow.step_exact(&mut exact, DT).unwrap();
        rmp::brake(&mut exact, &limits, DT).unwrap();
    }
    assert_eq!(count(), before);
}

#[test]
fn what_the_tool_carries_keeps_away_from_obstacles() {
    let files = panda();
    let mut flow = files.flow(1);
    let id = flow.add_target_frame("panda_hand_tcp").unwrap();
    let limits = files.limits();
    let wall = Obstacle::cuboid(
        Isometry3::translation(0.5, 0.5, 0.4),
        Vector3::new(1.0, 0.1, 1.0),
    );
    flow.obstacles_mut().add(wall).unwrap();
    let target = Vector3::new(0.5, 0.3, 0.4);
    flow.set_position_target(id, Some(target)).unwrap();
    // A pole of 0.3 m across the tool: it would reach through the wall.
    let pole = [0.0, 0.1, 0.2, 0.3].map(|reach| (Vector3::new(0.0, -reach, 0.0), 0.02));
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    flow.set_orientation_target(id, Some(down)).unwrap();
    let far = |flow: &mut RmpFlow| {
        let mut state = MotionState::at_rest(&flow.posture().to_vec());
        let mut report = None;
        for _ in 0..6000 {
            report = flow.step_cell(&mut state, &limits, DT).unwrap().clearance;
        }
        let at = flow.target_frame_pose(id).unwrap().translation.vector;
        (report.unwrap(), (at - target).norm())
    };
    let (_, error) = far(&mut flow);
    assert!(error < 0.01, "{error}");
    flow.carry(id, &pole).unwrap();
    assert_eq!(flow.carried_count(), 4);
    let (clearance, error) = far(&mut flow);
    assert!(clearance.distance > 0.0, "{clearance:?}");
    assert!(clearance.sphere >= files.xrdf.world_spheres.len());
    assert!(error > 0.05, "the wall is in the way: {error}");
    flow.drop_carried();
    let (_, error) = far(&mut flow);
    assert!(error < 0.01, "{error}");
}

#[test]
fn nonsense_is_not_carried() {
    let files = panda();
    let mut flow = files.flow(0);
    let id = flow.add_target_frame("panda_hand").unwrap();
    let ball = (Vector3::zeros(), 0.02);
    assert!(flow.carry(id, &[ball; MAX_CARRIED + 1]).is_err());
    assert!(flow.carry(id, &[(Vector3::zeros(), f64::NAN)]).is_err());
    assert_eq!(flow.carried_count(), 0);
}

#[test]
fn bad_steps_leave_the_state_alone() {
    let files = panda();
    let mut flow = files.flow(0);
    let mut state = MotionState::at_rest(&[0.0; 7]);
    let short = MotionState::at_rest(&[0.0; 6]);
    assert!(flow.step_exact(&mut short.clone(), DT).is_err());
    assert!(flow.step_exact(&mut state, 0.0).is_err());
    let mut limits = files.limits();
    limits.jerk[3] = f64::NAN;
    assert!(flow.step_cell(&mut state, &limits, DT).is_err());
    assert_eq!(state, MotionState::at_rest(&[0.0; 7]));
}
