//! Joints that copy another one: the refused ones, the joint that is controlled in their place,
//! and the limits that both have in common.

use std::path::PathBuf;

use cell_model::robots::urdf::{self, UrdfRobot};
use cell_model::{Robot, RobotFiles};

const LIMIT: &str = "<limit lower='-2' upper='2' velocity='2' effort='50'/>";

/// A chain of joints `j1`, `j2`, .. on lines 3, 4, .. with these contents.
fn chain(inner: &[&str]) -> String {
    let count = inner.len();
    let links: Vec<String> = (0..=count)
        .map(|i| format!("<link name='l{i}'/>"))
        .collect();
    let joints: Vec<String> = inner
        .iter()
        .enumerate()
        .map(|(i, inner)| {
            let (child, axis) = (i + 1, ["0 0 1", "0 1 0"][i.min(1)]);
            format!(
                "<joint name='j{child}' type='revolute'><parent link='l{i}'/>\
                 <child link='l{child}'/><origin xyz='0.1 0 0.3'/><axis xyz='{axis}'/>{inner}</joint>"
            )
        })
        .collect();
    format!(
        "<robot name='r'>\n{}\n{}\n</robot>",
        links.concat(),
        joints.join("\n")
    )
}

fn with(mimic: &str) -> String {
    format!("{LIMIT}{mimic}")
}

fn read(inner: &[&str]) -> UrdfRobot {
    urdf::parse("r.urdf", &chain(inner)).unwrap()
}

fn refused(inner: &[&str]) -> String {
    let read = urdf::parse("r.urdf", &chain(inner));
    read.expect_err("accepted").to_string()
}

/// Loads files of which the URDF has `text`.
fn load(name: &str, text: &str, xrdf: Option<&str>) -> Result<Robot, cell_model::ModelError> {
    let dir = tempfile::tempdir().unwrap();
    let write = |end: &str, text: &str| -> PathBuf {
        let path = dir.path().join(format!("{name}.{end}"));
        std::fs::write(&path, text).unwrap();
        path
    };
    Robot::from_files(&RobotFiles {
        urdf: write("urdf", text),
        xrdf: xrdf.map(|text| write("xrdf", text)),
        ..RobotFiles::default()
    })
}

#[test]
fn a_joint_that_copies_itself_and_a_circle_are_refused_with_the_line() {
    let of = |name: &str| with(&format!("<mimic joint='{name}'/>"));
    let said = refused(&[LIMIT, &of("j2")]);
    assert_eq!(
        said,
        "r.urdf:4: joint 'j2': mimic is of itself; name the joint that it follows, or remove mimic"
    );
    let said = refused(&[LIMIT, &of("j3"), &of("j4"), &of("j3")]);
    assert!(
        said.starts_with("r.urdf:5: joint 'j3': mimic is a circle j3 -> j4 -> j3; one joint of"),
        "{said}"
    );
}

#[test]
fn numbers_of_mimic_that_cannot_be_meant_are_refused() {
    for (key, value) in [
        ("multiplier", "0"),
        ("multiplier", "nan"),
        ("multiplier", "two"),
        ("offset", "inf"),
    ] {
        let said = refused(&[
            LIMIT,
            &with(&format!("<mimic joint='j1' {key}='{value}'/>")),
        ]);
        let wanted = format!("r.urdf:4: joint 'j2': mimic {key} is \"{value}\";");
        assert!(said.starts_with(&wanted), "{said}");
    }
}

#[test]
fn a_copy_of_a_copy_follows_the_joint_that_moves() {
    let robot = read(&[
        LIMIT,
        &with("<mimic joint='j3' multiplier='2' offset='0.1'/>"),
        &with("<mimic joint='j1' multiplier='-0.5' offset='0.2'/>"),
    ]);
    let joints = robot.chain.joints();
    let mimic = joints[1].mimic.unwrap();
    assert_eq!((mimic.joint, mimic.multiplier), (0, -1.0));
    assert!((mimic.offset - 0.5).abs() < 1e-12);
    // j2 is 0.5 - j1 and within 2, so j1 is above -1.5.
    assert!((joints[0].lower + 1.5).abs() < 1e-12 && joints[0].upper == 2.0);
    assert!((joints[1].lower + 1.5).abs() < 1e-12 && (joints[1].upper - 2.0).abs() < 1e-12);
}

#[test]
fn what_is_followed_moves_no_faster_than_what_follows() {
    let slow = "<limit lower='-2' upper='2' velocity='1' effort='0'/>\
                <mimic joint='j1' multiplier='-4'/>";
    let robot = read(&[LIMIT, slow]);
    assert_eq!(robot.limits[0].velocity, 0.25);
    assert_eq!(robot.chain.joints()[0].upper, 0.5);
}

#[test]
fn limits_without_a_common_range_are_reported() {
    let apart = "<limit lower='3' upper='4' velocity='1' effort='1'/><mimic joint='j1'/>";
    let robot = read(&[LIMIT, apart]);
    assert_eq!(robot.chain.joints()[0].upper, 2.0);
    assert_eq!(robot.chain.joints()[1].upper, 2.0);
    assert_eq!(
        robot.warnings,
        [
            "r.urdf:4: joint 'j2': its limits leave joint 'j1', which it copies, no range; those of \
          'j1' are taken"
        ]
    );
}

#[test]
fn a_joint_that_follows_has_no_place_in_the_arm() {
    let copies = with("<mimic joint='j2' multiplier='-1'/>");
    let text = chain(&[LIMIT, LIMIT, &copies, LIMIT, LIMIT, LIMIT]);
    let robot = load("arm", &text, None).unwrap();
    assert_eq!(robot.arm_joint_names(), ["j1", "j2", "j4", "j5", "j6"]);
    assert_eq!(robot.joints[2].home, -robot.joints[1].home);
    assert_eq!(robot.motion_policies(0).unwrap().joint_count(), 5);
    // An XRDF that names it contradicts the URDF.
    let xrdf = "{format: xrdf, cspace: {joint_names: [j2, j3], acceleration_limits: [1, 1], \
                jerk_limits: [100, 100]}}";
    let said = load("named", &text, Some(xrdf)).unwrap_err().to_string();
    assert!(
        said.contains("cspace.joint_names is j3; it copies joint 'j2'"),
        "{said}"
    );
}

#[test]
fn a_joint_before_the_tip_is_moved_by_the_one_it_copies_on_another_branch() {
    // The crank is beside the bar that follows it.
    let text = "<robot name='r'><link name='l0'/><link name='l1'/><link name='crank'/>\
        <link name='bar'/><link name='tip'/>\
        <joint name='j1' type='revolute'><parent link='l0'/><child link='l1'/>LIMIT</joint>\
        <joint name='motor' type='revolute'><parent link='l1'/><child link='crank'/>LIMIT</joint>\
        <joint name='driven' type='revolute'><parent link='l1'/><child link='bar'/>LIMIT\
        <mimic joint='motor'/></joint>\
        <joint name='j3' type='revolute'><parent link='bar'/><child link='tip'/>LIMIT</joint>\
        </robot>";
    let robot = load("crank", &text.replace("LIMIT", LIMIT), None).unwrap();
    assert_eq!(robot.arm_joint_names(), ["j1", "motor", "j3"]);
    assert_eq!(robot.tcp_frame_name(), "tip");
}
