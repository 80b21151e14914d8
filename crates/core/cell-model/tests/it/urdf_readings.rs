//! Numbers, types and templates of a URDF: those refused by line and joint, and those accepted
//! with a warning and its text.

use std::f64::consts::{PI, TAU};

use cell_model::robots::urdf::{self, UrdfRobot};

/// Two joints: `j1` on line 3 is sound, `j2` on line 4 is of `kind` with `inner`.
fn text(kind: &str, inner: &str) -> String {
    format!(
        "<robot name='x'>\n<link name='base'/><link name='l1'/><link name='l2'/>\n\
         <joint name='j1' type='revolute'><parent link='base'/><child link='l1'/>\
         <limit lower='-2' upper='2' velocity='1' effort='10'/></joint>\n\
         <joint name='j2' type='{kind}'><parent link='l1'/><child link='l2'/>{inner}</joint>\n\
         </robot>"
    )
}

fn limit(lower: &str, upper: &str, velocity: &str, effort: &str) -> String {
    format!("<limit lower='{lower}' upper='{upper}' velocity='{velocity}' effort='{effort}'/>")
}

fn read(kind: &str, inner: &str) -> UrdfRobot {
    urdf::parse("r.urdf", &text(kind, inner)).unwrap()
}

fn refused(kind: &str, inner: &str) -> String {
    let read = urdf::parse("r.urdf", &text(kind, inner));
    read.expect_err("accepted").to_string()
}

fn assert_warns(robot: &UrdfRobot, wanted: &[&str]) {
    let said = robot.warnings.join("\n");
    for part in wanted {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn a_xacro_file_is_named_as_such_with_the_line() {
    let plain = text("revolute", &limit("-1", "1", "1", "1"));
    let cases = [
        (
            plain.replace("<link name='base'/>", "<xacro:arm prefix='a'/>"),
            "r.urdf:2: this is a xacro file, not a URDF: it has the element 'xacro:arm'",
        ),
        (
            plain
                .replace(
                    "name='x'",
                    "name='x' xmlns:xacro='http://www.ros.org/wiki/xacro'",
                )
                .replace(
                    "<link name='base'/>",
                    "<xacro:macro name='m'><link name='base'/></xacro:macro>",
                ),
            "the element 'xacro:macro'",
        ),
        (
            plain.replace("lower='-1'", "lower='${-pi / 2}'"),
            "r.urdf:4: this is a xacro file, not a URDF: it has lower=\"${-pi / 2}\"",
        ),
        (
            plain.replace("lower='-1'", "lower='$(arg low)'"),
            "it has lower=\"$(arg low)\"",
        ),
    ];
    for (text, wanted) in cases {
        let said = urdf::parse("r.urdf", &text).unwrap_err().to_string();
        assert!(said.contains(wanted), "{said}");
        assert!(said.contains("`xacro r.urdf > robot.urdf`"), "{said}");
    }
}

#[test]
fn what_xacro_leaves_behind_does_not_matter() {
    let left = text("revolute", &limit("-1", "1", "1", "1")).replace(
        "name='x'>",
        "name='x' xmlns:xacro='http://www.ros.org/wiki/xacro'>\
         <!-- <xacro:arm prefix='${p}'/> --><xacro:property name='p' value='${q}'/>",
    );
    assert_eq!(
        urdf::parse("r.urdf", &left).unwrap().chain.joints().len(),
        2
    );
}

#[test]
fn types_that_cannot_be_loaded_are_refused_with_line_and_joint() {
    for kind in ["screw", "planar", "floating", "spherical"] {
        let said = refused(kind, "");
        let wanted = format!("r.urdf:4: joint 'j2': type is {kind}; revolute, continuous");
        assert!(said.starts_with(&wanted), "{said}");
    }
    let said = refused("revolut", "");
    assert!(
        said.contains("type is 'revolut'; did you mean 'revolute'?"),
        "{said}"
    );
}

#[test]
fn inf_and_numbers_without_meaning_are_no_limits() {
    for (low, high) in [("-inf", "inf"), ("-1e308", "1e308"), ("-1e16", "1e16")] {
        let robot = read("revolute", &limit(low, high, "inf", "inf"));
        let joint = &robot.chain.joints()[1];
        assert_eq!((joint.lower, joint.upper), (-2.0 * TAU, 2.0 * TAU));
        assert_eq!(
            (robot.limits[1].velocity, robot.limits[1].effort),
            (0.0, 0.0)
        );
        assert_warns(
            &robot,
            &[
                "r.urdf:4: joint 'j2': no limits, two turns",
                "1 rad/s is taken",
                "100 N m",
            ],
        );
    }
    let open = |low: &str, high: &str, kind: &str| {
        let robot = read(kind, &limit(low, high, "1", "1"));
        let joint = &robot.chain.joints()[1];
        (joint.lower, joint.upper)
    };
    assert_eq!(open("-0.5", "inf", "revolute"), (-0.5, 2.0 * TAU));
    assert_eq!(open("-inf", "0.5", "revolute"), (-2.0 * TAU, 0.5));
    assert_eq!(open("0.2", "inf", "prismatic"), (0.2, 1.2));
    assert_eq!(open("-inf", "inf", "prismatic"), (-1.0, 1.0));
}

#[test]
fn limits_that_contradict_each_other_are_refused() {
    for (low, high) in [("1", "-1"), ("inf", "-inf"), ("nan", "1"), ("0", "nan")] {
        let said = refused("revolute", &limit(low, high, "1", "1"));
        assert!(said.starts_with("r.urdf:4: joint 'j2': limit "), "{said}");
    }
    let said = refused("revolute", &limit("-pi", "1", "1", "1"));
    assert!(
        said.contains("r.urdf:4: joint 'j2': limit lower is \"-pi\"; a number is needed"),
        "{said}"
    );
    let said = refused("revolute", &limit("-1", "1", "fast", "1"));
    assert!(
        said.contains("joint 'j2': limit velocity is \"fast\""),
        "{said}"
    );
}

#[test]
fn limits_of_most_joints_in_degrees_are_taken_as_such_and_said() {
    let degrees = limit("-170", "170", "120", "50");
    let one = text("revolute", &degrees);
    let all = one.replace("lower='-2' upper='2'", "lower='-90' upper='90'");
    let robot = urdf::parse("r.urdf", &all).unwrap();
    let joint = &robot.chain.joints()[1];
    assert!((joint.upper - 170.0 * PI / 180.0).abs() < 1e-12);
    assert!((robot.limits[1].velocity - 120.0 * PI / 180.0).abs() < 1e-12);
    assert_warns(
        &robot,
        &[
            "joint 'j2': limits -170 to 170 rad: degrees? -2.9671 to 2.9671 rad are taken",
            "joint 'j2': velocity 120 rad/s: degrees? 2.0944 rad/s is taken",
        ],
    );
    // One of two joints is not enough: such numbers may mean no limit, too.
    let robot = urdf::parse("r.urdf", &one).unwrap();
    assert_eq!(robot.chain.joints()[1].upper, 2.0 * TAU);
    assert_warns(&robot, &["no limits (degrees?)"]);
    assert_warns(
        &read("prismatic", &limit("0", "500", "1", "1")),
        &["no upper limit (millimetres?), 1.000 m is taken"],
    );
}

#[test]
fn limits_of_zero_are_reported_once_for_all_joints() {
    let zero = limit("-1", "1", "0", "0");
    let both = text("revolute", &zero).replace("velocity='1' effort='10'", "velocity='0'");
    let robot = urdf::parse("r.urdf", &both).unwrap();
    assert_warns(
        &robot,
        &[
            "r.urdf:3: joints 'j1', 'j2': a limit of velocity of 0 allows no motion; 1 rad/s is",
            "r.urdf:4: joint 'j2': a limit of effort of 0 allows no motion; 100 N m is taken",
        ],
    );
    // A joint that copies another one has no drive.
    let copy = format!("{zero}<mimic joint='j1'/>");
    assert!(read("revolute", &copy).warnings.is_empty());
}

#[test]
fn soft_limits_within_the_limits_are_reported_and_calibration_is_not() {
    let with = |soft: &str| {
        let inner = format!(
            "{}<calibration rising='0.0'/><safety_controller k_velocity='1' {soft}/>",
            limit("-2", "2", "1", "1")
        );
        read("revolute", &inner).warnings
    };
    let narrow = with("soft_lower_limit='-1.5' soft_upper_limit='1.5'");
    assert_eq!(
        narrow,
        [
            "r.urdf:4: joint 'j2' (-1.5 to 1.5): soft limits of safety_controller are not applied, \
          those of limit are"
        ]
    );
    for equal_or_none in ["soft_lower_limit='-2' soft_upper_limit='2'", ""] {
        assert_eq!(with(equal_or_none), Vec::<String>::new());
    }
}
