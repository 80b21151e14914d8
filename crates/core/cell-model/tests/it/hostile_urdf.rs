//! Errors of a URDF are reported with a name, never with a panic.

use cell_model::robots::urdf;

const LINKS: &str = r#"<link name="base"/><link name="arm"/>"#;

fn joint(inner: &str) -> String {
    format!(
        r#"<joint name="j1" type="revolute"><parent link="base"/><child link="arm"/>{inner}</joint>"#
    )
}

const LIMIT: &str = r#"<limit lower="-1" upper="1" velocity="1" effort="10"/>"#;

fn refused(body: &str) -> String {
    urdf::parse("bad.urdf", &format!("<robot name='x'>{body}</robot>"))
        .unwrap_err()
        .to_string()
}

#[test]
fn a_sound_arm_loads() {
    let text = format!("<robot name='x'>{LINKS}{}</robot>", joint(LIMIT));
    let robot = urdf::parse("good.urdf", &text).unwrap();
    assert_eq!((robot.chain.joints().len(), robot.links.len()), (1, 2));
}

#[test]
fn structure_that_is_no_tree_is_named() {
    let loop_back =
        r#"<joint name="j2" type="fixed"><parent link="arm"/><child link="base"/></joint>"#;
    let second =
        r#"<joint name="j2" type="fixed"><parent link="base"/><child link="arm"/></joint>"#;
    let away = r#"<link name="a"/><link name="b"/>
        <joint name="k1" type="fixed"><parent link="a"/><child link="b"/></joint>
        <joint name="k2" type="fixed"><parent link="b"/><child link="a"/></joint>"#;
    let cases = [
        (
            format!("{LINKS}{}{loop_back}", joint(LIMIT)),
            "the joints form a cycle",
        ),
        (
            format!("{LINKS}{}{second}", joint(LIMIT)),
            "the child of joints 'j1' and 'j2'",
        ),
        (
            format!("{LINKS}{}{away}", joint(LIMIT)),
            "link 'a' is part of a cycle",
        ),
        (LINKS.to_owned(), "root link is one of base, arm"),
        (
            format!(r#"{LINKS}<link name="arm"/>{}"#, joint(LIMIT)),
            "link 'arm' is defined twice",
        ),
        (
            format!(r#"<link name="base"/>{}"#, joint(LIMIT)),
            "attached to 'arm'",
        ),
        (r#"<link name=""/>"#.to_owned(), "give it a name"),
        (String::new(), "root link"),
    ];
    for (body, expected) in cases {
        let error = refused(&body);
        assert!(
            error.starts_with("bad.urdf") && error.contains(expected),
            "{error}\nexpected {expected}"
        );
    }
}

#[test]
fn numbers_that_cannot_be_meant_are_named_with_their_owner() {
    let limit = |text: &str| format!("{LINKS}{}", joint(&format!("<limit {text}/>")));
    let inertial = |mass: &str, ixx: &str| {
        format!(
            r#"<link name="base"><inertial><mass value="{mass}"/>
            <inertia ixx="{ixx}" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>"#
        )
    };
    let cases = [
        (
            limit(r#"lower="nan" upper="1" velocity="1" effort="1""#),
            "joint 'j1': limit lower is NaN",
        ),
        (
            limit(r#"lower="1" upper="-1" velocity="1" effort="1""#),
            "it must be less than upper",
        ),
        (
            limit(r#"lower="-1" upper="1" velocity="1" effort="-5""#),
            "joint 'j1': limit effort is -5",
        ),
        (
            format!(
                "{LINKS}{}",
                joint(&format!(r#"<axis xyz="0 0 0"/>{LIMIT}"#))
            ),
            "a moving joint needs a direction",
        ),
        (
            format!(
                "{LINKS}{}",
                joint(&format!(r#"<origin xyz="0 0 0.1 0"/>{LIMIT}"#))
            ),
            "bad.urdf:1: joint 'j1': origin xyz is \"0 0 0.1 0\"; three numbers",
        ),
        (inertial("-1", "1"), "link 'base': mass is -1"),
        (inertial("nan", "1"), "link 'base': mass is NaN"),
        (inertial("1", "nan"), "link 'base': inertia is NaN"),
    ];
    for (body, expected) in cases {
        let error = refused(&body);
        assert!(error.contains(expected), "{error}\nexpected {expected}");
    }
}

#[test]
fn a_refused_number_has_the_line_of_its_joint() {
    let limit = r#"<limit lower="2" upper="1"/>"#;
    let error = refused(&format!("\n{LINKS}\n\n{}", joint(limit)));
    assert!(error.starts_with("bad.urdf:4: joint 'j1'"), "{error}");
}

#[test]
fn faults_that_leave_no_doubt_are_warnings_with_their_line() {
    let text = format!(
        r#"<!-- first --><?xml version="1.0"?><robot name="x">
        <xacro:property name="unbound prefix" value="1"/>
        <link name="base"><inertial><mass value="2"/>
          <inertia ixx="-1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
          <visual><origin xyz="not a number"/><geometry><mesh/></geometry></visual></link>
        <link name="arm"><collision><origin xyz="0 0"/><geometry><sphere radius="1"/></geometry>
          </collision></link>
        <link name="hand"/>
        {}
        <joint name="j2" type="fixed"><parent link="arm"/><child link="hand"/></joint>
        </robot>"#,
        joint(r#"<axis xyz="0, 0, 1"/><axis xyz="1 0 0"/><mimic joint="j7"/>"#)
    );
    let robot = urdf::parse("worn.urdf", &text).unwrap();
    let joints = robot.chain.joints();
    assert_eq!(joints.len(), 1);
    assert_eq!(joints[0].axis, nalgebra::Vector3::z());
    let turns = 4.0 * std::f64::consts::PI;
    assert!((joints[0].upper - turns).abs() < 1e-12);
    assert_eq!((robot.limits[0].velocity, joints[0].mimic), (0.0, None));
    let inertia = robot.links[0].inertia;
    assert!(inertia.symmetric_eigenvalues().min() > 0.0);
    assert!(robot.links[1].shapes.is_empty());
    let wanted = [
        ":3: link 'base': the inertia is not positive",
        ":6: link 'arm': a collision shape is unreadable",
        ":9: joint 'j1': no limits",
        ":9: 'j1' has a second axis",
        ":9: joint 'j1': mimic of joint 'j7'",
    ];
    for warning in wanted {
        let found = robot.warnings.iter().any(|said| said.contains(warning));
        assert!(found, "{warning}: {:#?}", robot.warnings);
    }
    assert_eq!(robot.warnings.len(), wanted.len());
}

/// A base with a collision shape on line 2, and an arm.
fn with_shape(shape: &str) -> String {
    format!(
        "<link name='base'>\n<collision><geometry>{shape}</geometry></collision></link>\n\
         <link name='arm'/>{}",
        joint(LIMIT)
    )
}

#[test]
fn a_shape_without_volume_is_left_out_and_said_and_is_no_mesh() {
    for shape in [
        "<sphere radius='0'/>",
        "<sphere/>",
        "<box size='0.1 0.1 0'/>",
        "<cylinder radius='0.1' length='-0.0'/>",
        "<capsule radius='0' length='0.1'/>",
    ] {
        let text = format!("<robot name='x'>{}</robot>", with_shape(shape));
        let robot = urdf::parse("flat.urdf", &text).unwrap();
        assert_eq!((robot.links[0].shapes.len(), robot.skipped_meshes), (0, 0));
        let wanted = "flat.urdf:2: link 'base': a collision shape with a length of 0 is left out";
        assert_eq!(robot.warnings, [wanted], "{shape}");
    }
}

#[test]
fn a_size_that_is_no_length_is_refused_with_its_link() {
    for (shape, value) in [
        ("<sphere radius='-0.1'/>", "-0.2 m"),
        ("<box size='0.1 -0.1 0.1'/>", "-0.1 m"),
        ("<cylinder radius='nan' length='0.1'/>", "NaN m"),
        ("<capsule radius='0.1' length='inf'/>", "inf m"),
    ] {
        let error = refused(&with_shape(shape));
        let wanted = format!("bad.urdf:1: link 'base': collision size is {value}; 0 to");
        assert!(error.contains(&wanted), "{error}");
    }
}

#[test]
fn a_default_namespace_is_that_of_the_urdf() {
    let text = format!(
        "<robot name='x' xmlns='http://www.ros.org'>{LINKS}{}</robot>",
        joint(LIMIT)
    );
    let robot = urdf::parse("good.urdf", &text).unwrap();
    assert_eq!((robot.chain.joints().len(), robot.links.len()), (1, 2));
}

#[test]
fn an_undeclared_prefix_is_declared_at_the_robot_and_not_in_a_comment() {
    for before in [
        "",
        "<!-- of <robot name='y'> -->",
        "<?note <robot?>",
        "<?xml version='1.0'?>\n<!-- <robot> --><!-- <robot --> ",
    ] {
        let text = format!(
            "{before}<robot name='x'>{LINKS}{}<sensor:camera/><other:thing/></robot>",
            joint(LIMIT)
        );
        let robot = urdf::parse("good.urdf", &text).unwrap();
        assert_eq!(robot.chain.joints().len(), 1, "{before}");
    }
}

#[test]
fn garbage_and_bombs_are_one_error() {
    let nested = format!(
        "<robot>{}{}</robot>",
        "<a>".repeat(20_000),
        "</a>".repeat(20_000)
    );
    let bomb = r#"<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>"#;
    for text in [
        "",
        "<robot",
        "\u{0}\u{1}",
        "<robot name='x'><link/></robot>",
        &nested,
        bomb,
        "<a><b></a></b>",
    ] {
        let error = urdf::parse("bad.urdf", text).unwrap_err().to_string();
        assert!(error.starts_with("bad.urdf"), "{error}");
    }
    let huge = " ".repeat(5 << 20);
    assert!(
        urdf::parse("bad.urdf", &huge)
            .unwrap_err()
            .to_string()
            .contains("bytes")
    );
}

#[test]
fn continuous_joints_get_two_turns_to_each_side() {
    let text = format!(
        "<robot name='x'>{LINKS}{}</robot>",
        joint("").replace("revolute", "continuous")
    );
    let joint = urdf::parse("good.urdf", &text).unwrap().chain.joints()[0].clone();
    assert!(
        (joint.upper - 4.0 * std::f64::consts::PI).abs() < 1e-12 && joint.lower == -joint.upper
    );
}
