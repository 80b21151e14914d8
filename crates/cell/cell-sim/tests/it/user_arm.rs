//! Arms of other people, from their URDF alone, in a cell of one process.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use cell_model::{Data, Robot, RobotFiles};
use cell_sim::OneProcess;
use cell_sim::eval::template;
use ipc_types::operator::OperatorAction;
use ipc_types::{OperatorRequest, Pose};
use nalgebra::Vector3;

/// One joint of a chain of links of `mass` (kg), 0.3 m apart: type, axis, then `limit` and
/// what else it has.
type Joint<'a> = (&'a str, &'a str, &'a str);

fn write_urdf(name: &str, mass: f64, joints: &[Joint<'_>]) -> PathBuf {
    let inertia = "ixx='0.02' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'";
    let mut text = format!("<robot name='{name}'>\n<link name='l0'/>\n");
    for (index, (kind, axis, rest)) in joints.iter().enumerate() {
        let link = index + 1;
        writeln!(
            text,
            "<link name='l{link}'><inertial><origin xyz='0 0 0.15'/><mass value='{mass}'/>\
             <inertia {inertia}/></inertial></link>\n\
             <joint name='j{link}' type='{kind}'><parent link='l{index}'/><child link='l{link}'/>\
             <origin xyz='0 0 0.3'/><axis xyz='{axis}'/>{rest}</joint>"
        )
        .unwrap();
    }
    text.push_str("</robot>");
    // Of this robot alone: `cell` removes it.
    let dir = format!("robocell-user-arm-{name}-{}", std::process::id());
    let dir = std::env::temp_dir().join(dir);
    std::fs::create_dir_all(&dir).unwrap();
    let path = dir.join(format!("{name}.urdf"));
    std::fs::write(&path, text).unwrap();
    path
}

/// The robot in the demo `reach`.
fn cell(urdf: &Path) -> (Robot, OneProcess) {
    let mut spec = template("reach", "follow");
    spec.time_limit_s = Some(100.0);
    spec.robot = Some(RobotFiles {
        urdf: urdf.to_path_buf(),
        ..RobotFiles::default()
    });
    let cell = spec.load_cell_from(&Data::checkout()).unwrap();
    std::fs::remove_dir_all(urdf.parent().unwrap()).unwrap();
    let robot = cell.arms[0].robot.clone();
    let sim = OneProcess::new(&demos::policies(), &spec, cell).unwrap();
    (robot, sim)
}

fn send_to(sim: &mut OneProcess, position: Vector3<f64>, orientation_wxyz: [f64; 4]) {
    let reply = sim.answer_request(&OperatorRequest {
        action: OperatorAction::Target.code(),
        pose: Pose {
            position: position.into(),
            orientation_wxyz,
        },
        ..OperatorRequest::zeroed_at_identity()
    });
    assert_eq!(reply.code, ipc_types::operator::ReplyCode::Accepted.code());
}

const TURNS: &str = "<limit lower='-2.5' upper='2.5' velocity='2' effort='300'/>";

/// Two bars of 8 kg of which the second stays upright, and a wrist.
#[test]
fn the_second_bar_of_a_parallelogram_follows_the_first_under_load() {
    let copies = format!("{TURNS}<mimic joint='j2' multiplier='-1' offset='0.2'/>");
    let urdf = write_urdf(
        "parallelogram",
        8.0,
        &[
            ("revolute", "0 0 1", TURNS),
            ("revolute", "0 1 0", TURNS),
            ("revolute", "0 1 0", &copies),
            ("revolute", "0 1 0", TURNS),
            ("revolute", "1 0 0", TURNS),
            ("revolute", "0 0 1", TURNS),
        ],
    );
    let (robot, mut sim) = cell(&urdf);
    assert_eq!(robot.arm_joint_names(), ["j1", "j2", "j4", "j5", "j6"]);
    // The range of the first bar is what both have in common.
    assert_eq!((robot.joints[1].lower, robot.joints[1].upper), (-2.3, 2.5));
    let goal = robot.with_arm_positions(&[0.6, 0.9, 1.1, -0.4, 0.3]);
    assert!((goal[2] - (0.2 - 0.9)).abs() < 1e-12);
    let goal = robot.frame_pose(robot.tcp_frame, &goal).unwrap();
    let [i, j, k, w] = goal.rotation.coords.into();
    sim.tick().unwrap();
    send_to(&mut sim, goal.translation.vector, [w, i, j, k]);
    let mut widest: f64 = 0.0;
    for _ in 0..6_000 {
        sim.tick().unwrap();
        let arm = &sim.state().arms()[0];
        assert_eq!((arm.limit_violations, arm.fault), (0, 0));
        let all = robot.with_arm_positions(&arm.joint_positions);
        let model = robot.frame_pose(robot.tcp_frame, &all).unwrap();
        let tcp = Vector3::from(arm.tcp.position);
        widest = widest.max((model.translation.vector - tcp).norm());
    }
    assert!(widest < 1e-4, "the bars part by {widest} m at the tool");
    let tcp = Vector3::from(sim.state().arms()[0].tcp.position);
    let off = (tcp - goal.translation.vector).norm();
    assert!(off < 5e-3, "{off} m off its goal");
}

/// Sends the tool to joint positions that are `part` of the way from the lower to the upper
/// limits. Returns how far off it is after `ticks` (m).
fn off_after(robot: &Robot, sim: &mut OneProcess, part: f64, ticks: u32) -> f64 {
    let goal: Vec<f64> = robot
        .arm_specs()
        .map(|spec| spec.lower + part * (spec.upper - spec.lower))
        .collect();
    let goal = robot.frame_pose(robot.tcp_frame, &robot.with_arm_positions(&goal));
    let goal = goal.unwrap();
    let [i, j, k, w] = goal.rotation.coords.into();
    send_to(sim, goal.translation.vector, [w, i, j, k]);
    for _ in 0..ticks {
        sim.tick().unwrap();
    }
    let arm = &sim.state().arms()[0];
    assert_eq!((arm.limit_violations, arm.fault), (0, 0));
    (Vector3::from(arm.tcp.position) - goal.translation.vector).norm()
}

/// The engine inverts the inertia, which was not finite then.
#[test]
fn links_without_inertia_about_one_axis_move() {
    let joints = [
        ("revolute", "0 0 1", TURNS),
        ("revolute", "0 1 0", TURNS),
        ("revolute", "0 0 1", TURNS),
        ("revolute", "0 1 0", TURNS),
    ];
    let urdf = write_urdf("rods", 0.5, &joints);
    let text = std::fs::read_to_string(&urdf).unwrap();
    let (origin, inertia) = ("xyz='0 0 0.15'", "ixx='0.02' iyy='0.02' izz='0.02'");
    let rods = text
        .replace(origin, "xyz='0 -0.0575318 0.0134998'")
        .replace(inertia, "ixx='0' iyy='0.0575321' izz='0.0195'");
    std::fs::write(&urdf, rods).unwrap();
    let (robot, mut sim) = cell(&urdf);
    sim.tick().unwrap();
    let off = off_after(&robot, &mut sim, 0.6, 3_000);
    assert!(off < 5e-3, "{off} m off");
}

#[test]
fn a_sliding_joint_with_a_short_stroke_goes_where_it_is_sent() {
    for stroke in [0.05, 0.005] {
        let slides = format!("<limit lower='0' upper='{stroke}' velocity='0.5' effort='500'/>");
        let name = format!("stroke_{stroke}");
        let urdf = write_urdf(&name, 1.0, &[("prismatic", "1 0 0", &slides)]);
        let (robot, mut sim) = cell(&urdf);
        sim.tick().unwrap();
        for part in [0.5, 0.9, 0.1] {
            let off = off_after(&robot, &mut sim, part, 2_000);
            assert!(off < 0.02 * stroke, "{stroke} m, part {part}: {off} m off");
        }
    }
}

#[test]
fn a_telescope_of_four_sections_and_a_wrist_reach_their_poses() {
    let slides = "<limit lower='0' upper='0.13' velocity='1' effort='100'/>";
    let mut joints = vec![("prismatic", "1 0 0", slides); 4];
    joints.push(("revolute", "0 0 1", TURNS));
    let (robot, mut sim) = cell(&write_urdf("telescope", 0.5, &joints));
    sim.tick().unwrap();
    for part in [0.5, 0.9, 0.1] {
        let off = off_after(&robot, &mut sim, part, 4_000);
        assert!(off < 2e-3, "part {part}: {off} m off");
    }
}

/// As legged robots do, whose base is at the height of their body.
#[test]
fn an_arm_that_starts_in_the_floor_moves_and_a_warning_says_so() {
    let joints = [
        ("revolute", "0 0 1", TURNS),
        ("revolute", "0 1 0", TURNS),
        ("revolute", "0 1 0", TURNS),
    ];
    let urdf = write_urdf("leg", 0.2, &joints);
    let text = std::fs::read_to_string(&urdf).unwrap();
    let shape = "<collision><geometry><box size='0.1 0.1 0.2'/></geometry></collision><inertial>";
    let leg = text
        .replace("<origin xyz='0 0 0.3'/>", "<origin xyz='0 0 -0.1'/>")
        .replace("<inertial>", shape);
    std::fs::write(&urdf, leg).unwrap();
    let (robot, mut sim) = cell(&urdf);
    let said = sim.take_warnings().join("\n");
    assert!(
        said.contains("inside fixture 'floor' with l1, l2, l3"),
        "{said}"
    );
    sim.tick().unwrap();
    let off = off_after(&robot, &mut sim, 0.6, 4_000);
    assert!(off < 5e-3, "{off} m off");
}

/// The drives of a file without efforts have to move the arm, not only to carry it.
#[test]
fn a_heavy_arm_without_efforts_in_its_file_follows() {
    let turns = "<limit lower='-2.5' upper='2.5' velocity='2'/>";
    let mut joints = vec![("revolute", "0 1 0", turns); 5];
    joints[0].1 = "0 0 1";
    let (robot, mut sim) = cell(&write_urdf("heavy", 900.0, &joints));
    sim.tick().unwrap();
    // Drives that are too weak swing, and are 0.45 m off.
    let off = off_after(&robot, &mut sim, 0.65, 5_000);
    assert!(off < 0.1, "{off} m off");
}
