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
