//! The UR10 and its suction tube: where they are, what they weigh, what they
//! stay clear of, and how little they bend.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use cell_model::{Data, Dynamics, Robot, RobotFiles, Shape};
use nalgebra::{Isometry3, Point3, Vector3};

fn ur10() -> Robot {
    Robot::load(&Data::checkout(), "ur10").unwrap()
}

/// Pose of a frame at these arm joints, base frame.
fn frame_pose(robot: &Robot, name: &str, q: &[f64]) -> Isometry3<f64> {
    let frame = robot.chain.frame_index(name).unwrap();
    robot
        .frame_pose(frame, &robot.with_arm_positions(q))
        .unwrap()
}

/// Joints that move a lot, another way each time.
fn some_joints(count: usize) -> Vec<f64> {
    (0..6)
        .map(|joint| 2.5 * libm::sin((joint * 7 + count * 3) as f64))
        .collect()
}

#[test]
fn a_ur10_has_a_cup_and_no_fingers() {
    let robot = ur10();
    assert_eq!(robot.arm_joints, [0, 1, 2, 3, 4, 5]);
    assert_eq!(robot.home(), [-1.57, -1.57, -1.57, -1.57, 1.57, 0.0]);
    assert_eq!(robot.tcp_frame_name(), "suction_tip");
    assert!(robot.gripper.is_none());
    let suction = robot.suction.unwrap();
    assert_eq!(suction.axis, Vector3::x());
    assert_eq!((suction.force_limit, suction.torque_limit), (50.0, 5.0));
    let total: f64 = robot.links.iter().map(|link| link.mass).sum();
    assert!((total - 32.9).abs() < 1.0e-9, "{total}");
    let panda = Robot::load(&Data::checkout(), "panda").unwrap();
    assert!(panda.suction.is_none() && panda.gripper.is_some());
}

#[test]
#[ignore = "compares with NVIDIA's files, which are not in this repository; ROBOCELL_REFERENCE names their folder"]
fn every_frame_is_where_the_published_robot_has_it() {
    let reference = std::env::var_os("ROBOCELL_REFERENCE").expect("the folder of the files");
    let reference = Path::new(&reference).join("ur10");
    let published = Robot::from_files(&RobotFiles {
        name: None,
        urdf: reference.join("ur10.urdf"),
        xrdf: Some(reference.join("ur10.xrdf")),
        rmpflow: Some(reference.join("ur10_rmpflow.yaml")),
        tip: None,
    })
    .unwrap();
    let ours = ur10();
    for count in 0..20 {
        let q = some_joints(count);
        for name in [
            "upper_arm_link",
            "forearm_link",
            "wrist_1_link",
            "ee_link",
            "tool0",
        ] {
            let (a, b) = (
                frame_pose(&ours, name, &q),
                frame_pose(&published, name, &q),
            );
            assert!(
                (a.translation.vector - b.translation.vector).norm() < 1.0e-12,
                "{name}"
            );
            assert!(a.rotation.angle_to(&b.rotation) < 1.0e-7, "{name}");
        }
    }
    assert_eq!(ours.limits(), published.limits());
    assert_eq!(ours.rmpflow.target, published.rmpflow.target);
    assert_eq!(ours.rmpflow.collision, published.rmpflow.collision);
    // Ours has the spheres of the tube besides.
    let of_tube = ours
        .spheres
        .iter()
        .filter(|s| s.frame == "suction_tube")
        .count();
    assert_eq!(ours.spheres.len() - of_tube, published.spheres.len());
}

#[test]
fn the_cup_is_at_the_end_of_the_tube_with_x_ahead() {
    let robot = ur10();
    let q = some_joints(1);
    let (flange, tip) = (
        frame_pose(&robot, "ee_link", &q),
        frame_pose(&robot, "suction_tip", &q),
    );
    let ahead = flange.inverse() * tip;
    assert!((ahead.translation.vector - Vector3::new(0.155, 0.0, 0.0)).norm() < 1.0e-12);
    assert!(ahead.rotation.angle() < 1.0e-7);
}

/// Lowest point of a shape at `pose` (m).
fn lowest(shape: &Shape, pose: &Isometry3<f64>) -> f64 {
    let up = pose.inverse() * Vector3::z();
    let reach = match *shape {
        Shape::Box { size_m: [x, y, z] } => {
            0.5 * (up.x.abs() * x + up.y.abs() * y + up.z.abs() * z)
        }
        Shape::Sphere { radius_m } => radius_m,
        Shape::Cylinder { radius_m, height_m } => {
            0.5 * height_m * up.z.abs() + radius_m * up.xy().norm()
        }
        Shape::Capsule { radius_m, height_m } => 0.5 * height_m * up.z.abs() + radius_m,
        Shape::Bin { .. } => f64::INFINITY,
    };
    pose.translation.vector.z - reach
}

#[test]
fn only_the_tube_goes_into_a_bin_when_the_cup_touches_its_floor() {
    let robot = ur10();
    // The tool points straight down at home but for the rounding of 1.57.
    let q = [
        -FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, FRAC_PI_2, 0.0,
    ];
    let tip = frame_pose(&robot, "suction_tip", &q);
    assert!((tip * Vector3::x() + Vector3::z()).norm() < 1.0e-9, "{tip}");
    // Bin 0.147 m high, floor at least 3 mm thick.
    let rim = tip.translation.vector.z + 0.144;
    let tube = frame_pose(&robot, "ee_link", &q) * Point3::new(0.0775, 0.0, 0.0);
    let poses = robot.link_poses(&robot.with_arm_positions(&q));
    // The wrist; everything before it is further up or away.
    for (link, pose) in robot.links.iter().zip(&poses).skip(3) {
        for part in &link.shapes {
            let at = pose * part.pose;
            if (at.translation.vector - tube.coords).norm() > 1.0e-6 {
                let low = lowest(&part.shape, &at);
                assert!(low > rim + 0.01, "{}: {low} rim {rim}", link.name);
            }
        }
    }
}

#[test]
fn five_kilograms_at_the_tip_of_the_stretched_arm_bend_it_by_less_than_a_millimetre() {
    let robot = ur10();
    // Stretched out sideways, the load 1.3 m from the shoulder.
    let q = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let load = Vector3::new(0.0, 0.0, -5.0 * 9.81);
    let tip = |q: &[f64]| frame_pose(&robot, "suction_tip", q).translation.vector;
    let at = tip(&q);
    let mut bend = Vector3::zeros();
    for joint in 0..6 {
        let mut moved = q;
        moved[joint] += 1.0e-6;
        let column = (tip(&moved) - at) / 1.0e-6;
        bend += column * column.dot(&load) / robot.joints[joint].stiffness;
    }
    assert!(bend.norm() < 1.0e-3, "{bend}");
}

#[test]
fn the_drives_carry_the_arm_and_five_kilograms_anywhere() {
    let robot = ur10();
    let mut dynamics = Dynamics::new(&robot);
    let still = [0.0; 6];
    for q in [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, -0.3, 0.3, PI, 0.5, 0.0],
    ] {
        let gravity = Vector3::new(0.0, 0.0, -9.81);
        let efforts = dynamics
            .inverse_dynamics(&q, &still, &still, &gravity)
            .to_vec();
        let reach = (frame_pose(&robot, "suction_tip", &q)
            .translation
            .vector
            .xy())
        .norm();
        for (joint, effort) in efforts.iter().enumerate().take(3) {
            let with_load = effort.abs() + 5.0 * 9.81 * reach;
            assert!(
                with_load < robot.joints[joint].effort,
                "{joint}: {with_load}"
            );
        }
    }
}
