//! Motion policies that are led along a path.

use std::sync::Arc;

use cell_rt::alloc::count;
use plan::{Ahead, Guide, Path, Scene, Settings, led};
use rmp::{MotionState, Obstacle, RmpFlow};

use crate::common::{Arm, LEFT, RIGHT, wall};

/// Motion policies of the arm among `solids`, 12 s from LEFT towards RIGHT, led along a path
/// or not: how far the tool ends from its goal (m), and the least clearance (m).
fn move_to_right(arm: &Arm, solids: &[Obstacle], path: Option<&Path>) -> (f64, f64) {
    let robot = &arm.robot;
    let mut flow = robot.motion_policies(solids.len()).unwrap();
    for solid in solids {
        flow.obstacles_mut().add(solid.clone()).unwrap();
    }
    let tool = flow.add_target_frame(robot.tcp_frame_name()).unwrap();
    let pose =
        |flow: &mut RmpFlow, at: &[f64]| flow.target_frame_pose_at(tool, at).unwrap().unwrap();
    let goal = pose(&mut flow, &RIGHT);
    let scene = Scene::new(solids).unwrap();
    let mut guide = path.map(|path| {
        let (posture, collision) = led(&robot.rmpflow);
        flow.set_gains(posture, collision).unwrap();
        let body = Arc::new(arm.body.clone());
        Guide::new(body, scene, path, &Settings::default(), Ahead::default())
    });
    let (limits, mut state) = (robot.limits(), MotionState::at_rest(&LEFT));
    let mut clearance = f64::INFINITY;
    for tick in 0..12_000 {
        let mut target = goal;
        if let Some(guide) = &mut guide {
            let next = guide.lead(&state.positions).to_vec();
            flow.set_posture(&next).unwrap();
            target = pose(&mut flow, &next);
        }
        flow.set_position_target(tool, Some(target.translation.vector))
            .unwrap();
        flow.set_orientation_target(tool, Some(target.rotation))
            .unwrap();
        flow.step_cell(&mut state, &limits, 1.0e-3).unwrap();
        if tick % 10 == 0 {
            clearance = clearance.min(arm.distance(&state.positions, solids));
        }
    }
    let end = pose(&mut flow, &state.positions);
    (
        (end.translation.vector - goal.translation.vector).norm(),
        clearance,
    )
}

#[test]
fn motion_policies_that_are_led_get_around_a_wall_before_which_they_would_stop() {
    let arm = Arm::new();
    let path = arm.plan(&wall(), &Settings::default()).unwrap();
    let (off, clearance) = move_to_right(&arm, &wall(), None);
    assert!(
        off > 0.1 && clearance > 0.0,
        "alone: {off} m off, {clearance}"
    );
    let (off, clearance) = move_to_right(&arm, &wall(), Some(&path));
    assert!(
        off < 0.01 && clearance > 0.0,
        "led: {off} m off, {clearance}"
    );
}

#[test]
fn what_moves_into_the_path_is_seen_ahead() {
    let arm = Arm::new();
    let path = arm.plan(&wall(), &Settings::default()).unwrap();
    let body = Arc::new(arm.body.clone());
    let scene = Scene::new(&wall()).unwrap();
    let mut guide = Guide::new(body, scene, &path, &Settings::default(), Ahead::default());
    guide.lead(&LEFT);
    assert!(guide.is_free_ahead(10.0));
    // A ball at the tool of the goal: far ahead, then near.
    let goal = arm.tool_at(&RIGHT);
    let ball = Obstacle::sphere(goal.translation.vector, 0.05);
    guide.scene.set(wall().iter().chain([&ball]));
    assert!(!guide.is_free_ahead(10.0));
    assert!(guide.is_free_ahead(0.1));
    let (at, length) = guide.progress();
    assert!(at < 0.1 && (length - path.length).abs() < 1e-9);
}

#[test]
fn a_cycle_that_is_led_allocates_nothing() {
    let arm = Arm::new();
    let path = arm.plan(&wall(), &Settings::default()).unwrap();
    let body = Arc::new(arm.body.clone());
    let scene = Scene::new(&wall()).unwrap();
    let mut guide = Guide::new(body, scene, &path, &Settings::default(), Ahead::default());
    let (mut at, obstacles) = (LEFT, wall());
    let before = count();
    assert!(before > 0, "allocations are counted");
    for _ in 0..500 {
        guide.scene.set(&obstacles);
        let next = guide.lead(&at);
        at.iter_mut()
            .zip(next)
            .for_each(|(q, to)| *q += 0.02 * (to - *q));
        guide.is_free_ahead(1.0);
    }
    assert_eq!(count(), before);
    assert!(guide.progress().0 > 0.5, "{:?}", guide.progress());
}
