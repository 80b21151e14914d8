//! Paths between two configurations.

use nalgebra::Vector3;
use plan::{Body, PlanError, Scene, Settings, plan};

use crate::common::{Arm, LEFT, RIGHT, cuboid, wall};

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
fn what_the_tool_holds_stays_off_the_scene() {
    let arm = Arm::new();
    let below = arm.tool_at(&LEFT).translation.vector.z - 0.3;
    let board = cuboid([0.5, 0.0, below], [0.8, 1.2, 0.02]);
    let scene = Scene::new([&board]).unwrap();
    let of = |body: &Body| plan(body, &scene, &LEFT, &RIGHT, &Settings::default());
    assert!(of(&arm.body).is_ok());
    // The tool is above the board, pointing down: a stick reaches through it.
    let stick: Vec<_> = (0..13)
        .map(|at| (Vector3::new(0.0, 0.0, 0.04 * f64::from(at)), 0.02))
        .collect();
    let refused = of(&arm.body.carrying(&stick)).unwrap_err();
    assert_eq!(refused, PlanError::InCollision { what: "start" });
    assert!(of(&arm.body.carrying(&stick[..1])).is_ok());
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
            .contains("start is not a configuration")
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
