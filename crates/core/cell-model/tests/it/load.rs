//! Errors and warnings that a user sees when robots and cells are loaded.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::fmt::Write as _;

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

#[test]
fn meshes_are_not_searched_for_and_said_to_be_missing_in_contact() {
    let mesh = "<geometry><mesh filename='package://nowhere/x.stl'/></geometry>";
    let text = format!(
        "<robot name='m'><link name='a'><visual>{mesh}</visual><collision>{mesh}</collision></link>\
         <link name='b'/><joint name='j' type='continuous'><parent link='a'/><child link='b'/>\
         </joint></robot>"
    );
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("mesh.urdf");
    std::fs::write(&path, text).unwrap();
    let files = RobotFiles {
        urdf: path,
        ..RobotFiles::default()
    };
    let warnings = Robot::from_files(&files).unwrap().warnings;
    assert!(
        warnings[0].contains("collision meshes (1) take no part in contact"),
        "{warnings:?}"
    );
}

/// A robot with two arms of three joints and a neck, in a separate folder.
fn two_arms(name: &str) -> std::path::PathBuf {
    let mut text = String::from("<robot name='both'><link name='body'/>");
    for (side, count) in [("left", 3), ("right", 3), ("neck", 1)] {
        for index in 1..=count {
            let parent = match index {
                1 => "body".to_owned(),
                _ => format!("{side}_{}", index - 1),
            };
            let _infallible = write!(
                text,
                "<link name='{side}_{index}'/><joint name='{side}_j{index}' type='revolute'>\
                 <parent link='{parent}'/><child link='{side}_{index}'/>\
                 <origin xyz='0 0 0.3'/><limit lower='-2' upper='2'/></joint>"
            );
        }
    }
    let file = std::env::temp_dir().join(format!("{name}-{}.urdf", std::process::id()));
    std::fs::write(&file, text + "</robot>").unwrap();
    file
}

#[test]
fn an_arm_without_a_posture_starts_bent_and_is_strong_enough_to_hold_itself() {
    let mut text = String::from("<robot name='stretched'><link name='l0'/>");
    for index in 1..=6 {
        let axis = if index % 2 == 1 { "0 0 1" } else { "0 1 0" };
        let _infallible = write!(
            text,
            "<link name='l{index}'><inertial><mass value='2'/><origin xyz='0 0 0.1'/></inertial>\
             </link><joint name='j{index}' type='revolute'><parent link='l{}'/>\
             <child link='l{index}'/><origin xyz='0 0 0.2'/><axis xyz='{axis}'/>\
             <limit lower='-2.5' upper='2.5' effort='5'/></joint>",
            index - 1
        );
    }
    let file = std::env::temp_dir().join(format!("stretched-{}.urdf", std::process::id()));
    std::fs::write(&file, text + "</robot>").unwrap();
    let robot = Robot::from_files(&RobotFiles {
        urdf: file.clone(),
        ..RobotFiles::default()
    })
    .unwrap();
    std::fs::remove_file(&file).unwrap();
    // At zero the arm points straight up, and cannot move up or down.
    let home = robot.home();
    assert!(home.iter().all(|q| q.abs() <= 0.6), "{home:?}");
    assert!(home[1].abs() > 0.1 && home[3].abs() > 0.1, "{home:?}");
    // Ten kilograms 0.6 m from the second joint.
    let lifting = robot.joints[1].effort;
    assert!((100.0..300.0).contains(&lifting), "{lifting}");
    let warning = &robot.warnings[0];
    assert!(
        warning.contains("joint 'j2': an effort of 5.0"),
        "{warning}"
    );
    // The first one turns about a vertical axis.
    assert_eq!(robot.joints[0].effort, 5.0);
}

#[test]
fn a_leg_of_two_joints_starts_bent() {
    let mut text = String::from("<robot name='leg'><link name='l0'/><link name='foot'/>");
    for (index, at) in [(1, "0 0.2 0"), (2, "0 0 -0.16")] {
        let _infallible = write!(
            text,
            "<link name='l{index}'/><joint name='j{index}' type='revolute'>\
             <parent link='l{}'/><child link='l{index}'/><origin xyz='{at}'/><axis xyz='1 0 0'/>\
             <limit lower='-10' upper='10' effort='1000' velocity='10'/></joint>",
            index - 1
        );
    }
    text += "<joint name='end' type='fixed'><parent link='l2'/><child link='foot'/>\
             <origin xyz='0 0 -0.16'/></joint></robot>";
    let file = std::env::temp_dir().join(format!("leg-{}.urdf", std::process::id()));
    std::fs::write(&file, text).unwrap();
    let robot = Robot::from_files(&RobotFiles {
        urdf: file.clone(),
        ..RobotFiles::default()
    })
    .unwrap();
    std::fs::remove_file(&file).unwrap();
    // At zero it is stretched, and no target above the hip moves it.
    let home = robot.home();
    assert!(home[1].abs() > 0.3, "{home:?}");
}

#[test]
fn of_several_arms_the_first_is_controlled_or_the_one_that_is_named() {
    let urdf = two_arms("several-arms");
    let load = |tip: Option<&str>| {
        Robot::from_files(&RobotFiles {
            urdf: urdf.clone(),
            tip: tip.map(str::to_owned),
            ..RobotFiles::default()
        })
    };
    let first = load(None).unwrap();
    assert_eq!(first.arm_joint_names(), ["left_j1", "left_j2", "left_j3"]);
    let warning = &first.warnings[0];
    for words in [
        "'left_3' is controlled",
        "--tip LINK",
        "right_3 (3)",
        "neck_1 (1)",
    ] {
        assert!(warning.contains(words), "{warning}");
    }
    let named = load(Some("right_2")).unwrap();
    assert_eq!(named.arm_joint_names(), ["right_j1", "right_j2"]);
    assert_eq!(named.tcp_frame_name(), "right_2");
    let error = load(Some("right_4")).unwrap_err().to_string();
    assert!(error.contains("did you mean 'right_"), "{error}");
    let none = load(Some("body")).unwrap_err().to_string();
    assert!(
        none.contains("left_3 (3), right_3 (3), neck_1 (1)"),
        "{none}"
    );
    std::fs::remove_file(&urdf).unwrap();
}

#[test]
fn an_arm_whose_files_say_nothing_of_self_collision_keeps_away_from_itself() {
    let data = Data::checkout_dir().join("robots/panda");
    let text = std::fs::read_to_string(data.join("panda.xrdf")).unwrap();
    let section = text.find("self_collision:").unwrap();
    let rest = text[section..].find("\ngeometry:").unwrap();
    let without = format!("{}{}", &text[..section], &text[section + rest..]);
    let xrdf = std::env::temp_dir().join(format!("silent-{}.xrdf", std::process::id()));
    std::fs::write(&xrdf, without).unwrap();
    let files = RobotFiles {
        urdf: data.join("panda.urdf"),
        xrdf: Some(xrdf.clone()),
        ..RobotFiles::default()
    };
    let robot = Robot::from_files(&files).unwrap();
    std::fs::remove_file(&xrdf).unwrap();
    assert_eq!(robot.self_spheres, robot.spheres);
    let may_touch = |a: &str, b: &str| {
        let mut pairs = robot.self_ignore.iter();
        pairs.any(|(c, d)| (c == a && d == b) || (c == b && d == a))
    };
    // Neighbours meet at their joint, the last two links are one body with the hand.
    assert!(may_touch("panda_link3", "panda_link4"));
    assert!(may_touch("panda_link7", "panda_hand"));
    // The hand reaches the first links, and must not.
    for link in ["panda_link1", "panda_link2"] {
        assert!(
            !may_touch(link, "panda_hand"),
            "{link}: {:?}",
            robot.self_ignore
        );
    }
}

#[test]
fn an_object_lies_as_its_orientation_says_and_a_wrong_one_is_refused() {
    let cell = |extra: &str| {
        let dir = tempfile::tempdir().unwrap();
        let dir = dir.path();
        std::fs::create_dir_all(dir.join("cells")).unwrap();
        let text = std::fs::read_to_string(Data::checkout_dir().join("cells/reach.toml")).unwrap();
        let object = "[[object]]\nname = \"tube\"\nshape = { kind = \"cylinder\", radius_m = 0.02, \
                      height_m = 0.1 }\nmass_kg = 0.1\nfriction = 0.8\ncolour = [0.5, 0.5, 0.5]\n\
                      position_m = [0.5, 0.3, 0.02]\n";
        std::fs::write(
            dir.join("cells/reach.toml"),
            format!("{text}\n{object}{extra}\n"),
        )
        .unwrap();
        let data = Data::dir(dir).with_robots_of(&Data::checkout());
        Cell::load(&data, "reach", 3, None)
    };
    let lying = cell("orientation_wxyz = [0.7071, 0.7071, 0.0, 0.0]").unwrap();
    let axis = lying.objects[0].pose.rotation * nalgebra::Vector3::z();
    assert!(
        axis.z.abs() < 1.0e-9 && (axis.norm() - 1.0).abs() < 1.0e-12,
        "{axis}"
    );
    let refused = cell("orientation_wxyz = [1.0, 1.0, 0.0, 0.0]").unwrap_err();
    assert!(
        refused.to_string().contains("object.0.orientation_wxyz"),
        "{refused}"
    );
}

/// A cell of a demo with one text in place of another.
fn changed(demo: &str, from: &str, to: &str) -> Result<Cell, String> {
    let data = Data::checkout();
    let text = data.read(&format!("cells/{demo}.toml")).unwrap();
    assert!(text.contains(from), "{from}");
    let text = text.replacen(from, to, 1);
    Cell::from_text(&data, demo, "mine.toml", &text, 0, None).map_err(|error| error.to_string())
}

#[test]
fn a_belt_that_nothing_can_rest_on_is_refused() {
    let belt = "name = \"belt\"\n";
    let error = changed("ur10-palletize", belt, &format!("{belt}solid = false\n")).unwrap_err();
    let text = Data::checkout().read("cells/ur10-palletize.toml").unwrap();
    // One line of the belt is new, below the table of the conveyor.
    let line = 1 + text
        .lines()
        .position(|l| l == "fixture = \"belt\"")
        .unwrap();
    for part in [
        format!("mine.toml:{line}: conveyor.fixture is 'belt'"),
        "solid = false".to_owned(),
        "name another fixture".to_owned(),
    ] {
        assert!(error.contains(&part), "{error}");
    }
    assert!(changed("ur10-palletize", belt, &format!("{belt}solid = true\n")).is_ok());
}

#[test]
fn sizes_of_a_cell_that_are_no_lengths_are_refused() {
    let size = "size_m = [0.73, 1.55, 0.10]";
    let (range, finite) = ("0.001 to 20 is allowed", "a finite number is needed");
    for (value, allowed) in [
        ("0.0", range),
        ("-0.1", range),
        ("1e-9", range),
        ("nan", finite),
        ("inf", finite),
    ] {
        let other = format!("size_m = [0.73, {value}, 0.10]");
        let error = changed("ur10-palletize", size, &other).unwrap_err();
        assert!(error.contains(".shape.size_m"), "{error}");
        assert!(error.contains(allowed), "{error}");
    }
}
