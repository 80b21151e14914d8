//! What a user notices when loading robots and cells.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use cell_model::{Cell, Data, Robot, RobotFiles};

fn stack(seed: u64) -> Cell {
    Cell::load(&Data::checkout(), "franka-stack", seed, None).unwrap()
}

#[test]
fn the_stack_demo_has_a_panda_and_four_cubes() {
    let cell = stack(1);
    let names: Vec<&str> = cell.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(
        names,
        ["red_cube", "blue_cube", "green_cube", "yellow_cube"]
    );
    let robot = &cell.arms[0].robot;
    assert_eq!(robot.arm_joints, [0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(robot.tcp_frame_name(), "panda_hand_tcp");
    assert_eq!(robot.gripper.as_ref().unwrap().finger_joints, [7, 8]);
    assert_eq!(robot.links.len(), 10);
    let total: f64 = robot.links.iter().map(|link| link.mass).sum();
    assert!((total - 17.451_901).abs() < 1e-6, "{total}");
}

#[test]
fn the_seed_moves_cubes_within_their_areas_and_nothing_else_does() {
    assert_eq!(stack(5).objects, stack(5).objects);
    assert_ne!(stack(5).objects, stack(6).objects);
    for seed in 0..50 {
        for object in stack(seed).objects {
            let shift = object.pose.translation.vector - object.nominal.translation.vector;
            assert!(shift.x.abs() <= 0.015 && shift.y.abs() <= 0.02 && shift.z == 0.0);
            assert!((object.pose.rotation / object.nominal.rotation).angle() <= 0.1746);
            assert!((0.8..=1.0).contains(&object.friction));
        }
    }
}

#[test]
fn the_hand_points_straight_down_for_the_quaternion_0_1_0_0() {
    let robot = Robot::load(&Data::checkout(), "panda").unwrap();
    let positions = robot.with_arm_positions(&[
        0.0,
        -FRAC_PI_4,
        0.0,
        -3.0 * FRAC_PI_4,
        0.0,
        FRAC_PI_2,
        FRAC_PI_4,
    ]);
    let tcp = robot.frame_pose(robot.tcp_frame, &positions).unwrap();
    let down =
        nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(0.0, 1.0, 0.0, 0.0));
    assert!(tcp.rotation.angle_to(&down) < 1e-9);
    assert!(
        (tcp.translation.vector.x - 0.306_890_6).abs() < 1e-4,
        "{tcp}"
    );
}

#[test]
fn a_mistyped_demo_gets_a_suggestion() {
    let error = Cell::load(&Data::checkout(), "franka-stak", 0, None)
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "unknown demo 'franka-stak'; did you mean 'franka-stack'?"
    );
}

#[test]
fn a_mistyped_robot_is_named_with_its_line_in_the_cell() {
    let data = Data::checkout();
    let text = data.read("cells/reach.toml").unwrap();
    let wrong = text.replacen("robot = \"panda\"", "robot = \"pandaa\"", 1);
    let error = Cell::from_text(&data, "mine", "mine.toml", &wrong, 0, None).unwrap_err();
    let line = 1 + text.lines().position(|l| l.starts_with("robot =")).unwrap();
    let wanted =
        format!("mine.toml:{line}: arm.0.robot is 'pandaa'; no such robot; did you mean 'panda'?");
    assert_eq!(error.to_string(), wanted);
}

#[test]
fn a_missing_urdf_is_named() {
    let files = RobotFiles {
        urdf: "no/such.urdf".into(),
        ..RobotFiles::default()
    };
    let error = Cell::load(&Data::checkout(), "reach", 0, Some(&files))
        .unwrap_err()
        .to_string();
    assert!(error.contains("no/such.urdf"), "{error}");
}
