//! Paths of a Panda around a wall, checked in double precision.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::collections::BTreeMap;

use cell_model::{Data, Robot};
use cell_rt::alloc::count;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use std::sync::Arc;

use plan::{
    Ahead, Body, BodySetup, Guide, Path, PlanError, Scene, Settings, Stuck, Tool, led, plan,
    plan_to_pose, reason,
};
use rmp::{JointLimits, MotionState, Obstacle, RmpFlow};

#[global_allocator]
static ALLOCATOR: cell_rt::alloc::Counting = cell_rt::alloc::Counting;

const LEFT: [f64; 7] = [0.7, 0.2, 0.0, -2.0, 0.0, 2.2, 0.75];
const RIGHT: [f64; 7] = [-0.7, 0.2, 0.0, -2.0, 0.0, 2.2, 0.75];

struct Arm {
    robot: Robot,
    body: Body,
}

impl Arm {
    fn new() -> Self {
        let robot = Robot::load(&Data::checkout(), "panda").unwrap();
        let names = robot.chain.joints().iter().map(|joint| joint.name.clone());
        let defaults: BTreeMap<String, f64> = names
            .zip(robot.fixed_joint_positions.iter().copied())
            .collect();
        let body = Body::new(&BodySetup {
            chain: &robot.chain,
            joint_names: &robot.arm_joint_names(),
            default_positions: &defaults,
            spheres: &robot.spheres,
            self_spheres: &[],
            self_ignore: &[],
        });
        Self {
            body: body.unwrap(),
            robot,
        }
    }

    fn tool_at(&self, at: &[f64]) -> Isometry3<f64> {
        let mut all = self.robot.fixed_joint_positions.clone();
        for (&joint, position) in self.robot.arm_joints.iter().zip(at) {
            all[joint] = *position;
        }
        self.robot.frame_pose(self.robot.tcp_frame, &all).unwrap()
    }

    /// Least distance of a moving sphere from a solid (m), by the kinematics of `cell_model`.
    fn distance(&self, at: &[f64], solids: &[Obstacle]) -> f64 {
        let mut all = self.robot.fixed_joint_positions.clone();
        for (&joint, position) in self.robot.arm_joints.iter().zip(at) {
            all[joint] = *position;
        }
        let links = self.robot.link_poses(&all);
        let frames = self.robot.chain.frames();
        let mut least = f64::INFINITY;
        for sphere in &self.robot.spheres {
            let frame = &frames[self.robot.chain.frame_index(&sphere.frame).unwrap()];
            let Some(joint) = frame.joint else { continue };
            let center = links[joint + 1] * frame.pose * Point3::from(sphere.center);
            for solid in solids {
                least = least.min(solid.distance(&center) - sphere.radius);
            }
        }
        least
    }

    fn along(&self, waypoints: &[Vec<f64>], solids: &[Obstacle]) -> f64 {
        let mut least = f64::INFINITY;
        for pair in waypoints.windows(2) {
            for part in 0..=500 {
                let part = f64::from(part) / 500.0;
                let joints = pair[0].iter().zip(&pair[1]);
                let at: Vec<f64> = joints.map(|(a, b)| a + part * (b - a)).collect();
                least = least.min(self.distance(&at, solids));
            }
        }
        least
    }

    fn plan(&self, solids: &[Obstacle], settings: &Settings) -> Result<Path, PlanError> {
        let scene = Scene::new(solids).unwrap();
        plan(&self.body, &scene, &LEFT, &RIGHT, settings)
    }
}

fn cuboid(at: [f64; 3], sides: [f64; 3]) -> Obstacle {
    let pose = Isometry3::translation(at[0], at[1], at[2]);
    Obstacle::cuboid(pose, Vector3::from(sides))
}

/// Before the arm, across the straight way of the tool.
fn wall() -> Vec<Obstacle> {
    let post = Obstacle::cylinder(Isometry3::translation(0.3, 0.0, 0.9), 0.05, 0.3);
    vec![cuboid([0.6, 0.0, 0.2], [0.5, 0.04, 0.7]), post]
}

#[test]
fn an_arm_goes_around_a_wall_and_touches_nothing() {
    let arm = Arm::new();
    let straight = [LEFT.to_vec(), RIGHT.to_vec()];
    assert!(
        arm.along(&straight, &wall()) < 0.0,
        "the wall is in the way"
    );
    for seed in 0..5 {
        let settings = Settings {
            seed,
            ..Settings::default()
        };
        let path = arm.plan(&wall(), &settings).unwrap();
        assert_eq!(path.waypoints.first().unwrap(), &LEFT);
        assert_eq!(path.waypoints.last().unwrap(), &RIGHT);
        let clearance = arm.along(&path.waypoints, &wall());
        assert!(clearance >= 0.0, "seed {seed}: {clearance}");
        let limits = arm.robot.limits();
        for at in &path.waypoints {
            let within = at.iter().zip(limits.lower.iter().zip(&limits.upper));
            assert!(within.clone().all(|(q, (low, high))| low <= q && q <= high));
        }
    }
}

#[test]
fn without_a_wall_the_way_is_straight() {
    let path = Arm::new().plan(&[], &Settings::default()).unwrap();
    assert_eq!(path.waypoints, [LEFT.to_vec(), RIGHT.to_vec()]);
    assert_eq!(path.iterations, 0);
    assert!((path.length - 1.4).abs() < 1e-12);
}

#[test]
fn the_same_request_has_the_same_answer_and_another_seed_another_one() {
    let arm = Arm::new();
    let of = |seed: u64| {
        let settings = Settings {
            seed,
            ..Settings::default()
        };
        arm.plan(&wall(), &settings).unwrap()
    };
    assert_eq!(of(1), of(1));
    assert_ne!(of(1).waypoints, of(u64::MAX).waypoints);
}

#[test]
fn what_cannot_be_planned_is_named() {
    let arm = Arm::new();
    let scene = Scene::new(&wall()).unwrap();
    let with = |start: &[f64], goal: &[f64]| {
        plan(&arm.body, &scene, start, goal, &Settings::default()).unwrap_err()
    };
    let mut nan = LEFT;
    nan[3] = f64::NAN;
    assert!(
        with(&nan, &RIGHT)
            .to_string()
            .contains("start is no configuration")
    );
    let mut beyond = RIGHT;
    beyond[1] = 1.9;
    assert!(
        with(&LEFT, &beyond)
            .to_string()
            .contains("joint 1 is at 1.9")
    );
    assert!(with(&LEFT, &RIGHT[..6]).to_string().contains("joint 6"));
    let mut inside = LEFT;
    inside[0] = 0.0;
    assert_eq!(
        with(&inside, &RIGHT),
        PlanError::InCollision { what: "start" }
    );
    assert!(Scene::new(&[cuboid([f64::NAN, 0.0, 0.0], [1.0; 3])]).is_err());
}

#[test]
fn the_effort_is_bounded_by_iterations() {
    let arm = Arm::new();
    let needed = arm.plan(&wall(), &Settings::default()).unwrap().iterations;
    assert!(needed > 0);
    let settings = Settings {
        max_iterations: needed - 1,
        ..Settings::default()
    };
    let refused = arm.plan(&wall(), &settings).unwrap_err();
    let iterations = needed - 1;
    assert_eq!(refused, PlanError::NotFound { iterations });
}

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
    let posture = &arm.robot.default_joint_positions;
    let starts = (&LEFT[..], &posture[..]);
    let path = plan_to_pose(
        &arm.body,
        &scene,
        &mut tool,
        starts,
        goal,
        &Settings::default(),
    )?;
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
    // In the middle of the wall.
    let inside = Isometry3::from_parts(Vector3::new(0.6, 0.0, 0.2).into(), goal.rotation);
    let refused = to_pose(&arm, &inside, &wall()).unwrap_err();
    assert_eq!(refused, PlanError::InCollision { what: "goal" });
}

#[test]
fn what_keeps_an_arm_from_its_target_has_a_reason() {
    let arm = Arm::new();
    let mut flow = arm.robot.motion_policies(0).unwrap();
    let tool = flow.add_target_frame(arm.robot.tcp_frame_name()).unwrap();
    let (limits, posture) = (arm.robot.limits(), &arm.robot.default_joint_positions);
    let narrow = JointLimits {
        lower: LEFT.iter().map(|q| q - 0.2).collect(),
        upper: LEFT.iter().map(|q| q + 0.2).collect(),
        ..limits.clone()
    };
    let mut why_within =
        |limits: &JointLimits, at: &[f64], goal: &Isometry3<f64>, solids: &[Obstacle]| {
            let scene = Scene::new(solids).unwrap();
            let stuck = Stuck {
                body: &arm.body,
                scene: &scene,
                limits,
                at,
                posture,
                goal,
            };
            reason(&stuck, &mut flow, tool, &Settings::default()).name()
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
fn ten_thousand_obstacles_have_an_answer_within_bounds() {
    let arm = Arm::new();
    let ball = |index: u32| {
        let along = |n: u32| f64::from(index / n % 22) / 22.0;
        let at = Vector3::new(along(1) - 0.2, along(22) - 0.5, 1.2 + along(484));
        Obstacle::sphere(at, 0.01)
    };
    let mut many: Vec<Obstacle> = (0..10_000).map(ball).collect();
    many.extend(wall());
    assert!(arm.plan(&many, &Settings::default()).is_ok());
    // A plate that the arm gets around on no side.
    many.push(cuboid([1.2, 0.0, 1.0], [2.0, 0.04, 4.0]));
    let settings = Settings {
        max_looks: 3_000_000,
        ..Settings::default()
    };
    let refused = arm.plan(&many, &settings).unwrap_err();
    let PlanError::NotFound { iterations } = refused else {
        panic!("{refused}");
    };
    assert!(iterations < 1_000, "{iterations}");
}

#[test]
fn what_is_no_scene_and_no_arm_is_named() {
    let nan = Obstacle::sphere(Vector3::new(f64::NAN, 0.0, 0.0), 0.1);
    assert!(
        Scene::new([&nan])
            .unwrap_err()
            .to_string()
            .contains("not a finite position")
    );
    let robot = Robot::load(&Data::checkout(), "panda").unwrap();
    let body = |joints: &[String]| {
        Body::new(&BodySetup {
            chain: &robot.chain,
            joint_names: joints,
            default_positions: &BTreeMap::new(),
            spheres: &[],
            self_spheres: &[],
            self_ignore: &[],
        })
    };
    let refused = body(&["elbow".to_owned()]).unwrap_err();
    assert_eq!(refused.to_string(), "the robot has no joint 'elbow'");
    assert_eq!(
        body(&[]).unwrap_err().to_string(),
        "0 joints cannot be planned; 1 to 16 are allowed"
    );
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

#[test]
fn every_shape_is_touched_where_its_distance_says() {
    let arm = Arm::new();
    let hull = [
        [0.3, 0.0, 0.0],
        [0.0, 0.2, 0.0],
        [0.0, 0.0, 0.3],
        [-0.1, -0.1, -0.1],
    ];
    let (mut free, mut touching) = (0, 0);
    for step in 0..300_u32 {
        let along = |n: u32| f64::from(step / n % 7) / 7.0;
        let turn = UnitQuaternion::from_euler_angles(along(1), 3.0 * along(7), 2.0 * along(49));
        let at = Vector3::new(0.35 + 0.5 * along(1), along(7) - 0.4, 0.8 * along(49));
        let pose = Isometry3::from_parts(at.into(), turn);
        for solid in [
            Obstacle::cuboid(pose, Vector3::new(0.2, 0.1, 0.3)),
            Obstacle::cylinder(pose, 0.1, 0.3),
            Obstacle::cone(pose, 0.2, 0.3),
            Obstacle::hull(pose, &hull.map(Vector3::from)).unwrap(),
        ] {
            let solids = [solid];
            let distance = arm.distance(&LEFT, &solids);
            if distance.abs() < 1e-4 {
                continue;
            }
            let scene = Scene::new(&solids).unwrap();
            let found = plan(&arm.body, &scene, &LEFT, &LEFT, &Settings::default());
            assert_eq!(found.is_ok(), distance > 0.0, "{solids:?}: {distance}");
            (free, touching) = (
                free + i32::from(distance > 0.0),
                touching + i32::from(distance < 0.0),
            );
        }
    }
    assert!(free > 100 && touching > 100, "{free} {touching}");
}
