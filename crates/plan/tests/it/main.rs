//! Paths of a Panda around a wall, checked in double precision.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;

use cell_model::{Data, Robot};
use nalgebra::{Isometry3, Point3, Vector3};
use plan::{Body, BodySetup, Path, PlanError, Scene, Settings, Solid, plan};
use rmp::Obstacle;

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

    /// Least distance of a moving sphere from a solid (m), by the kinematics of `cell_model`.
    fn distance(&self, at: &[f64], solids: &[Solid]) -> f64 {
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

    fn along(&self, waypoints: &[Vec<f64>], solids: &[Solid]) -> f64 {
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

    fn plan(&self, solids: &[Solid], settings: &Settings) -> Result<Path, PlanError> {
        let scene = Scene::new(solids).unwrap();
        plan(&self.body, &scene, &LEFT, &RIGHT, settings)
    }
}

fn cuboid(at: [f64; 3], sides: [f64; 3]) -> Solid {
    let pose = Isometry3::translation(at[0], at[1], at[2]);
    Solid::Rounded(Obstacle::cuboid(pose, Vector3::from(sides)))
}

/// Before the arm, across the straight way of the tool.
fn wall() -> Vec<Solid> {
    let post = Solid::Cylinder {
        pose: Isometry3::translation(0.3, 0.0, 0.9),
        radius: 0.05,
        height: 0.3,
    };
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
    assert!(Scene::new(&[cuboid([f64::NAN, 0.0, 0.0], [1.0; 3])]).is_none());
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

#[test]
fn distances_of_solids_are_signed() {
    let post = Solid::Cylinder {
        pose: Isometry3::translation(0.0, 0.0, 1.0),
        radius: 0.5,
        height: 2.0,
    };
    let of = |x: f64, z: f64| post.distance(&Point3::new(x, 0.0, z));
    assert!((of(1.5, 1.0) - 1.0).abs() < 1e-12);
    assert!((of(0.8, 2.4) - 0.5).abs() < 1e-12);
    assert!((of(0.4, 1.0) + 0.1).abs() < 1e-12);
    let wall = cuboid([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]);
    assert!((wall.distance(&Point3::new(0.0, 0.0, 0.7)) + 0.3).abs() < 1e-12);
}
