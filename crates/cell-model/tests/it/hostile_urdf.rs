//! What is wrong with a URDF is said with its name, never with a panic.

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
            limit(r#"lower="-1" upper="inf" velocity="1" effort="1""#),
            "joint 'j1': limit upper is inf",
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
            limit(r#"lower="-1" upper="1" velocity="1e999" effort="1""#),
            "joint 'j1': limit velocity is inf",
        ),
        (
            format!("{LINKS}{}", joint("")),
            "joint 'j1': limit is missing",
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
                joint(&format!(r#"<mimic joint="j7"/>{LIMIT}"#))
            ),
            "no such joint",
        ),
        (inertial("-1", "1"), "link 'base': mass is -1"),
        (inertial("nan", "1"), "link 'base': mass is NaN"),
        (inertial("1", "nan"), "link 'base': inertia is NaN"),
        (inertial("1", "-1"), "link 'base': inertia is not positive"),
    ];
    for (body, expected) in cases {
        let error = refused(&body);
        assert!(error.contains(expected), "{error}\nexpected {expected}");
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
