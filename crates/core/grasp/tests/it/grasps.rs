//! Grasps of objects in surroundings, by the robots of the checkout.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use cell_model::{Data, Robot, Shape};
use grasp::{
    Approach, Body, Candidate, Depth, Exclusion, Grasps, Gripper, Scene, SetDown, grasps, set_down,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

fn gripper(robot: &str) -> Gripper {
    Gripper::of(&Robot::load(&Data::checkout(), robot).unwrap()).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Isometry3<f64> {
    Translation3::new(x, y, z).into()
}

fn cuboid(x: f64, y: f64, z: f64) -> Shape {
    Shape::Box { size_m: [x, y, z] }
}

/// An object at `pose` on a table, with fixtures around it.
fn scene(shape: &Shape, pose: Isometry3<f64>, fixtures: &[(Shape, Isometry3<f64>)]) -> Scene {
    let table = (cuboid(2.0, 2.0, 0.1), at(0.0, 0.0, -0.05));
    let all = [table].into_iter().chain(fixtures.iter().cloned());
    let body = |(index, (shape, pose)): (usize, (Shape, _))| {
        Body::new(&format!("fixture_{index}"), &shape, Some(pose))
    };
    Scene {
        fixtures: all.enumerate().map(body).collect(),
        objects: vec![Body::new("object", shape, Some(pose))],
        arms: Vec::new(),
    }
}

fn panda(scene: &Scene) -> Grasps {
    grasps(&gripper("panda"), scene, 0, None)
}

fn best(grasps: &Grasps) -> &Candidate {
    grasps
        .best()
        .unwrap_or_else(|| panic!("{:?}", grasps.refusal()))
}

fn reason(grasps: &Grasps) -> &'static str {
    assert_eq!(grasps.best(), None);
    grasps.refusal().map_or("", Exclusion::reason)
}

/// The turn of the direction in which the fingers close about the vertical, below half a turn.
fn closing_yaw(candidate: &Candidate) -> f64 {
    let axis = candidate.tcp.rotation * Vector3::y();
    axis.y.atan2(axis.x).rem_euclid(std::f64::consts::PI)
}

#[test]
fn a_cube_is_gripped_from_above_at_its_centre_along_its_sides() {
    for turn in [0.0, 0.3, -0.7] {
        let pose = at(0.5, 0.1, 0.025) * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
        let found = panda(&scene(&cuboid(0.05, 0.05, 0.05), pose, &[]));
        let best = best(&found);
        assert_eq!(
            (best.approach, best.depth),
            (Approach::Above, Depth::Centre)
        );
        assert!((best.tcp.translation.vector - pose.translation.vector).norm() < 1.0e-9);
        let off = (closing_yaw(best) - turn).rem_euclid(FRAC_PI_2);
        assert!(!(1.0e-6..FRAC_PI_2 - 1.0e-6).contains(&off), "{off}");
    }
}

#[test]
fn a_long_box_is_gripped_across() {
    let found = panda(&scene(&cuboid(0.04, 0.12, 0.04), at(0.5, 0.0, 0.02), &[]));
    let best = best(&found);
    assert!((best.width_m - 0.04).abs() < 1.0e-9);
    assert!(closing_yaw(best).sin().abs() < 1.0e-6, "along x");
    let wide = Exclusion::TooWide {
        width_m: 0.12,
        opens_m: 0.078,
    };
    let has = |of: &Candidate| of.excluded.as_ref().map(Exclusion::reason) == Some(wide.reason());
    assert!(found.candidates.iter().any(has), "along y");
}

#[test]
fn a_tall_box_is_gripped_at_its_upper_part() {
    let found = panda(&scene(&cuboid(0.05, 0.05, 0.16), at(0.5, 0.0, 0.08), &[]));
    let above = found
        .candidates
        .iter()
        .filter(|of| of.approach == Approach::Above);
    let mut centre = above.clone().filter(|of| of.depth == Depth::Centre);
    let is_in_hand = |of: &Candidate| of.excluded == Some(Exclusion::Hand);
    assert!(centre.all(is_in_hand));
    let best = best(&found);
    assert_eq!((best.approach, best.depth), (Approach::Above, Depth::Upper));
    let height = best.tcp.translation.vector.z;
    assert!(height > 0.13 && height < 0.16, "{height}");
}

#[test]
fn a_plate_is_gripped_as_low_as_the_table_lets_the_tips() {
    let tips_m = 0.012;
    for thickness in [0.006, 0.008, 0.01] {
        let pose = at(0.5, 0.0, 0.5 * thickness);
        let found = panda(&scene(&cuboid(0.05, 0.05, thickness), pose, &[]));
        let best = best(&found);
        assert_eq!((best.approach, best.depth), (Approach::Above, Depth::Low));
        let height = best.tcp.translation.vector.z;
        assert!(height > 0.009 && height < tips_m, "{thickness}: {height}");
    }
    let sheet = panda(&scene(
        &cuboid(0.05, 0.05, 0.001),
        at(0.5, 0.0, 0.0005),
        &[],
    ));
    assert_eq!(reason(&sheet), "too_thin");
}

#[test]
fn round_and_lying_bodies_are_gripped_across() {
    let lying = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
    let shapes = [
        (Shape::Sphere { radius_m: 0.03 }, at(0.5, 0.0, 0.03)),
        (
            Shape::Cylinder {
                radius_m: 0.02,
                height_m: 0.12,
            },
            at(0.5, 0.0, 0.02) * lying,
        ),
        (
            Shape::Capsule {
                radius_m: 0.02,
                height_m: 0.06,
            },
            at(0.5, 0.0, 0.02) * lying,
        ),
    ];
    for (shape, pose) in shapes {
        let found = panda(&scene(&shape, pose, &[]));
        let best = best(&found);
        assert_eq!(best.approach, Approach::Above, "{shape:?}");
        assert!(best.width_m < 0.061, "{shape:?}");
        if !matches!(shape, Shape::Sphere { .. }) {
            assert!(closing_yaw(best).sin().abs() < 1.0e-6, "across {shape:?}");
        }
    }
    let upright = Shape::Cylinder {
        radius_m: 0.03,
        height_m: 0.06,
    };
    let found = panda(&scene(&upright, at(0.5, 0.0, 0.03), &[]));
    let mut yaws = found.candidates.iter().filter(|of| of.excluded.is_none());
    let is_oblique = |of: &Candidate| (closing_yaw(of) - FRAC_PI_4).abs() < 1.0e-6;
    assert!(yaws.any(is_oblique), "45 degrees, too");
}

#[test]
fn a_wall_beside_the_cube_leaves_the_other_way_and_walls_on_all_sides_none() {
    let cube = cuboid(0.05, 0.05, 0.05);
    let wall = (cuboid(0.3, 0.005, 0.05), at(0.5, -0.028, 0.025));
    let found = panda(&scene(
        &cube,
        at(0.5, 0.0, 0.025),
        std::slice::from_ref(&wall),
    ));
    let best_one = best(&found);
    assert_eq!(best_one.approach, Approach::Above);
    assert!(closing_yaw(best_one).sin().abs() < 1.0e-6, "along the wall");
    let others = [
        wall,
        (cuboid(0.3, 0.005, 0.05), at(0.5, 0.028, 0.025)),
        (cuboid(0.005, 0.3, 0.05), at(0.472, 0.0, 0.025)),
        (cuboid(0.005, 0.3, 0.05), at(0.528, 0.0, 0.025)),
    ];
    let found = panda(&scene(&cube, at(0.5, 0.0, 0.025), &others));
    assert_eq!(reason(&found), "blocked_by_fixture");
}

#[test]
fn neighbours_and_what_is_on_top_are_named() {
    let cube = cuboid(0.05, 0.05, 0.05);
    let mut cell = scene(&cube, at(0.5, 0.0, 0.025), &[]);
    for (index, (x, y)) in [(0.056, 0.0), (-0.056, 0.0), (0.0, 0.056), (0.0, -0.056)]
        .into_iter()
        .enumerate()
    {
        let name = format!("neighbour_{index}");
        cell.objects
            .push(Body::new(&name, &cube, Some(at(0.5 + x, y, 0.025))));
    }
    let found = panda(&cell);
    assert_eq!(reason(&found), "blocked_by_object");
    let text = found.refusal().map(ToString::to_string).unwrap_or_default();
    assert!(text.starts_with("neighbour_"), "{text}");
    cell.objects.truncate(1);
    cell.objects
        .push(Body::new("lid", &cube, Some(at(0.5, 0.0, 0.075))));
    let found = panda(&cell);
    let above = |of: &&Candidate| of.approach == Approach::Above;
    let mut above = found.candidates.iter().filter(above);
    assert!(above.all(|of| of.excluded == Some(Exclusion::Object("lid".to_owned()))));
}

#[test]
fn a_cup_needs_a_face_for_its_rim_and_follows_a_tilted_one() {
    let cup = gripper("ur10");
    let on_table = |size: f64, turn: UnitQuaternion<f64>| {
        let pose = at(0.7, 0.0, 0.1) * turn;
        grasps(&cup, &scene(&cuboid(size, size, 0.06), pose, &[]), 0, None)
    };
    let level = UnitQuaternion::identity();
    assert_eq!(best(&on_table(0.04, level)).approach, Approach::Above);
    assert_eq!(reason(&on_table(0.038, level)), "cup_larger_than_face");
    for degrees in [10.0_f64, 20.0, 30.0] {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), degrees.to_radians());
        let found = on_table(0.1, turn);
        let normal = best(&found).tcp.rotation * Vector3::x();
        let wanted = turn * -Vector3::z();
        assert!((normal - wanted).norm() < 1.0e-9, "{degrees}: {normal}");
    }
    let ball = scene(&Shape::Sphere { radius_m: 0.1 }, at(0.7, 0.0, 0.1), &[]);
    assert_eq!(
        reason(&grasps(&cup, &ball, 0, None)),
        "cup_larger_than_face"
    );
}

#[test]
fn what_the_arm_does_not_reach_is_excluded_last() {
    let mut found = panda(&scene(&cuboid(0.05, 0.05, 0.05), at(0.5, 0.0, 0.025), &[]));
    let before = found
        .candidates
        .iter()
        .filter(|of| of.excluded.is_none())
        .count();
    found.ask_reach(|tcp| (tcp.rotation * Vector3::z()).z > -0.9);
    assert!(
        found
            .best()
            .is_some_and(|of| of.approach != Approach::Above)
    );
    assert!(before > 4);
    found.ask_reach(|_| false);
    assert_eq!(reason(&found), "object_out_of_reach");
}

#[test]
fn an_object_is_set_down_where_it_and_the_hand_fit() {
    let hand = gripper("panda");
    let cube = cuboid(0.05, 0.05, 0.05);
    let turn = |angle: f64| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let why = |wall: &Shape, y: f64, angle: f64| {
        let mut scene = scene(&cube, at(0.5, -0.3, 0.025), &[]);
        let pose = at(0.5, y, 0.025);
        scene.fixtures.push(Body::new("wall", wall, Some(pose)));
        let goal = at(0.5, 0.3, 0.025);
        let tcp = goal * turn(angle) * down;
        let of = SetDown {
            object: 0,
            width_m: 0.05,
            opening_m: 0.08,
            goal: &goal,
            tcp: &tcp,
        };
        set_down(&hand, &scene, &of).map_or("", |why| why.reason())
    };
    let wall = cuboid(0.3, 0.005, 0.05);
    // 2.5 mm beside the cube: between the object and an open finger, but a closed one hits it.
    assert_eq!(why(&wall, 0.27, 0.0), "blocked_by_fixture");
    assert_eq!(why(&wall, 0.27, FRAC_PI_2), "");
    assert_eq!(why(&wall, 0.28, FRAC_PI_2), "blocked_by_fixture");
    assert_eq!(why(&wall, 0.2, 0.0), "");
}
