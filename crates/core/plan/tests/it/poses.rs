//! Paths to a pose, and why there is none.

use nalgebra::{Isometry3, Vector3};
use plan::{Path, PlanError, Request, Scene, Settings, Tool, plan_to_pose, reason};
use rmp::{JointLimits, Obstacle};

use crate::common::{Arm, LEFT, RIGHT, wall};

/// A path from LEFT to a pose of the tool among `solids`, and how far its end is off (m, rad).
fn to_pose(
    arm: &Arm,
    goal: &Isometry3<f64>,
    solids: &[Obstacle],
) -> Result<(Path, f64, f64), PlanError> {
    let mut flow = arm.robot.motion_policies(0).unwrap();
    let id = flow.add_target_frame(arm.robot.tcp_frame_name()).unwrap();
    let limits = arm.robot.limits();
    let mut tool = Tool::new(&mut flow, id, &limits);
    let scene = Scene::new(solids).unwrap();
    let request = Request {
        body: &arm.body,
        scene: &scene,
        start: &LEFT,
        posture: &arm.robot.default_joint_positions,
        goal,
    };
    let path = plan_to_pose(&request, &mut tool, &Settings::default())?;
    let end = flow
        .target_frame_pose_at(id, path.waypoints.last().unwrap())
        .unwrap()
        .unwrap();
    let off = (end.translation.vector - goal.translation.vector).norm();
    Ok((path, off, end.rotation.angle_to(&goal.rotation)))
}

#[test]
fn a_pose_behind_a_wall_is_reached_and_one_that_cannot_be_is_named() {
    let arm = Arm::new();
    let goal = arm.tool_at(&RIGHT);
    let (path, off_m, off_rad) = to_pose(&arm, &goal, &wall()).unwrap();
    assert!(off_m < 1e-3 && off_rad < 1e-2, "{off_m} {off_rad}");
    assert!(arm.along(&path.waypoints, &wall()) >= 0.0);
    let far = Isometry3::translation(3.0, 0.0, 0.0) * goal;
    let refused = to_pose(&arm, &far, &wall()).unwrap_err();
    assert!(
        matches!(refused, PlanError::Unreachable { off_m, .. } if off_m > 1.0),
        "{refused}"
    );
    let nowhere = Isometry3::translation(f64::NAN, 0.0, 0.0);
    assert_eq!(to_pose(&arm, &nowhere, &[]).unwrap_err(), PlanError::Pose);
    // In the middle of the wall.
    let inside = Isometry3::from_parts(Vector3::new(0.6, 0.0, 0.2).into(), goal.rotation);
    let refused = to_pose(&arm, &inside, &wall()).unwrap_err();
    assert_eq!(refused, PlanError::InCollision { what: "goal" });
}

#[test]
fn what_keeps_an_arm_from_its_target_has_a_reason() {
    let arm = Arm::new();
    let mut flow = arm.robot.motion_policies(0).unwrap();
    let frame = flow.add_target_frame(arm.robot.tcp_frame_name()).unwrap();
    let (limits, posture) = (arm.robot.limits(), &arm.robot.default_joint_positions);
    let narrow = JointLimits {
        lower: LEFT.iter().map(|q| q - 0.2).collect(),
        upper: LEFT.iter().map(|q| q + 0.2).collect(),
        ..limits.clone()
    };
    let mut why_within =
        |limits: &JointLimits, at: &[f64], goal: &Isometry3<f64>, solids: &[Obstacle]| {
            let scene = Scene::new(solids).unwrap();
            let request = Request {
                body: &arm.body,
                scene: &scene,
                start: at,
                posture,
                goal,
            };
            let mut tool = Tool::new(&mut flow, frame, limits);
            reason(&request, &mut tool, &Settings::default()).name()
        };
    let goal = arm.tool_at(&RIGHT);
    assert_eq!(why_within(&narrow, &LEFT, &goal, &[]), "joint_limit");
    let mut why = |at: &[f64], goal: &Isometry3<f64>, solids: &[Obstacle]| {
        why_within(&limits, at, goal, solids)
    };
    assert_eq!(why(&LEFT, &goal, &[]), "local_minimum");
    assert_eq!(why(&LEFT, &goal, &wall()), "blocked");
    let inside = Isometry3::from_parts(Vector3::new(0.6, 0.0, 0.2).into(), goal.rotation);
    assert_eq!(why(&LEFT, &inside, &wall()), "blocked");
    let far = Isometry3::translation(3.0, 0.0, 0.0) * goal;
    assert_eq!(why(&LEFT, &far, &[]), "unreachable");
    // Stretched upwards.
    let upright = [0.0, 0.0, 0.0, -0.075, 0.0, 1.0, 0.0];
    assert_eq!(why(&upright, &goal, &[]), "singular");
}
