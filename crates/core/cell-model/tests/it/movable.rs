//! A robot that loads and whose tip no target can move has a warning with the reason and
//! advice.

use std::fmt::Write as _;
use std::path::PathBuf;

use cell_model::{Robot, RobotFiles};

const TURN: &str = "<limit lower='-2' upper='2' velocity='1' effort='10'/>";

fn file(dir: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let path = dir.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// A column that carries `wheel`, which turns about its own middle, and beside it `arm`, with
/// `limit`, which carries `hand`.
fn cart(limit: &str) -> String {
    format!(
        "<robot name='cart'>\n<link name='base'/><link name='wheel'/><link name='arm'/>\
         <link name='hand'/>\n\
         <joint name='spin' type='continuous'><parent link='base'/><child link='wheel'/>\
         <origin xyz='0.3 0 0.1'/><axis xyz='0 1 0'/></joint>\n\
         <joint name='lift' type='revolute'><parent link='base'/><child link='arm'/>\
         <origin xyz='0 0 0.1'/><axis xyz='0 1 0'/>{limit}</joint>\n\
         <joint name='mount' type='fixed'><parent link='arm'/><child link='hand'/>\
         <origin xyz='0.4 0 0'/></joint>\n</robot>"
    )
}

fn load(name: &str, text: &str, tip: Option<&str>) -> Robot {
    let dir = tempfile::tempdir().unwrap();
    let files = RobotFiles {
        urdf: file(&dir, &format!("{name}.urdf"), text),
        tip: tip.map(str::to_owned),
        ..RobotFiles::default()
    };
    Robot::from_files(&files).unwrap()
}

/// The warning about a tip that stays where it is.
fn said(robot: &Robot) -> Option<&String> {
    let about = |warning: &&String| warning.contains("the tip") || warning.contains("tuning");
    robot.warnings.iter().find(about)
}

fn assert_says(robot: &Robot, wanted: &[&str]) {
    let said = said(robot).unwrap_or_else(|| panic!("{:?}", robot.warnings));
    for part in wanted {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn a_wheel_as_the_tip_is_named_with_its_joint_and_the_links_that_move() {
    let wheel = load("wheel", &cart(TURN), Some("wheel"));
    assert_says(
        &wheel,
        &[
            "wheel.urdf: no target can change the position of the tip 'wheel'",
            "joint 'spin' turns about an axis through it",
            "`--tip LINK` can name a link that moves: hand",
        ],
    );
    let hand = load("hand", &cart(TURN), Some("hand"));
    assert_says(
        &hand,
        &["tip 'hand' can only move along a line (joints: lift)"],
    );
}

#[test]
fn a_single_wheel_needs_a_link_away_from_its_axis() {
    let text = "<robot name='cube'><link name='world'/><link name='cube'/>\
                <joint name='spin' type='continuous'><parent link='world'/><child link='cube'/>\
                <axis xyz='0 0 1'/></joint></robot>";
    assert_says(
        &load("cube", text, None),
        &["tip 'cube'", "'spin'", "add one by a fixed joint"],
    );
}

#[test]
fn a_range_of_next_to_nothing_is_named() {
    let limit = "<limit lower='0' upper='0.001' velocity='1' effort='10'/>";
    let text = cart(limit);
    assert_says(
        &load("narrow", &text, Some("hand")),
        &[
            "tip 'hand'",
            "joint 'lift' has a range of 0.001 only",
            "widen the limits",
        ],
    );
}

#[test]
fn a_tip_that_can_be_as_near_to_a_target_as_it_comes_says_so() {
    let of = |axes: &[&str]| {
        let mut text = String::from("<robot name='r'><link name='l0'/>");
        for (index, axis) in axes.iter().enumerate() {
            let child = index + 1;
            let _infallible = write!(
                text,
                "<link name='l{child}'/><joint name='j{child}' type='prismatic'>\
                 <parent link='l{index}'/><child link='l{child}'/><axis xyz='{axis}'/>\
                 <limit lower='-0.05' upper='0' velocity='0.1' effort='10'/></joint>"
            );
        }
        load(
            &format!("sliders-{}", axes.len()),
            &(text + "</robot>"),
            None,
        )
    };
    let (x, y, z) = ("1 0 0", "0 1 0", "0 0 1");
    assert_says(
        &of(&[x]),
        &["tip 'l1' can only move along a line (joints: j1)"],
    );
    assert_says(
        &of(&[x, y]),
        &["tip 'l2' can only move on a surface (joints: j1, j2)"],
    );
    assert_eq!(said(&of(&[x, y, z])), None);
}

#[test]
fn limits_of_motion_next_to_zero_are_named() {
    let limit = "<limit lower='-2' upper='2' velocity='0.00001' effort='10'/>";
    assert_says(
        &load("slow", &cart(limit), Some("hand")),
        &["tip 'hand' needs 250.0 s", "joint 'lift' 0.00001, 10, 500"],
    );
}

#[test]
fn joints_of_an_xrdf_that_are_not_before_the_tip_are_named() {
    let xrdf = "format: xrdf\nformat_version: 1.0\ncspace: {joint_names: [spin], \
                acceleration_limits: [10], jerk_limits: [500]}\ntool_frames: [hand]\n";
    let dir = tempfile::tempdir().unwrap();
    let robot = Robot::from_files(&RobotFiles {
        urdf: file(&dir, "beside.urdf", &cart(TURN)),
        xrdf: Some(file(&dir, "beside.xrdf", xrdf)),
        ..RobotFiles::default()
    });
    assert_says(
        &robot.unwrap(),
        &["tip 'hand'", "joint 'spin' is not before it"],
    );
}

#[test]
fn a_tuning_without_pull_is_named() {
    let panda = cell_model::Data::checkout();
    let tuning = panda.read("robots/panda/panda_rmpflow.yaml").unwrap();
    let weak = tuning.replacen("accel_p_gain: ", "accel_p_gain: 0 # ", 1);
    let dir = tempfile::tempdir().unwrap();
    let files = RobotFiles {
        urdf: file(
            &dir,
            "weak.urdf",
            &panda.read("robots/panda/panda.urdf").unwrap(),
        ),
        rmpflow: Some(file(&dir, "weak.yaml", &weak)),
        ..RobotFiles::default()
    };
    assert_says(
        &Robot::from_files(&files).unwrap(),
        &["rmp_params.target_rmp.accel_p_gain is 0"],
    );
}

#[test]
fn the_robots_of_the_demos_have_nothing_to_say() {
    for name in ["panda", "ur10"] {
        let robot = Robot::load(&cell_model::Data::checkout(), name).unwrap();
        assert_eq!(said(&robot), None);
    }
}
