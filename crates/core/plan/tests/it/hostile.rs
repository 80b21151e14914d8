//! Many obstacles, every shape, and invalid scenes and arms.

use std::collections::BTreeMap;

use cell_model::{Data, Robot};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use plan::{Body, BodySetup, PlanError, Scene, Settings, plan};
use rmp::Obstacle;

use crate::common::{Arm, LEFT, cuboid, wall};

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
            tool: "hand",
        })
    };
    let refused = body(&["elbow".to_owned()]).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the robot has no actuated joint 'elbow'"
    );
    assert_eq!(
        body(&[]).unwrap_err().to_string(),
        "0 joints cannot be planned; 1 to 16 are allowed"
    );
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
