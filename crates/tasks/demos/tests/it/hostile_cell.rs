//! A cell file with an error gets one message with line, key and what to do.

use cell_model::{Cell, Data};

fn stack_text() -> String {
    Data::checkout()
        .read("cells/franka-stack.toml")
        .unwrap()
        .into_owned()
}

/// The message for the stack cell with one text replaced by another.
fn refused(from: &str, to: &str) -> String {
    refused_in(&stack_text(), from, to)
}

fn refused_in(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    let text = text.replacen(from, to, 1);
    error_of("cells/x.toml", &text)
}

/// The message of a run of this cell, which does not come about.
fn error_of(file: &str, text: &str) -> String {
    let cell = match Cell::from_text(&Data::checkout(), "x", file, text, 0, None) {
        Ok(cell) => cell,
        Err(error) => return error.to_string(),
    };
    let task = demos::policies().task(&cell, &cell.default_policy);
    task.err().unwrap().to_string()
}

fn line_with(from: &str) -> usize {
    stack_text()
        .lines()
        .position(|line| line.contains(from))
        .unwrap()
        + 1
}

#[test]
fn typing_errors_in_keys_are_answered_with_the_right_key() {
    let cases = [
        (
            "time_limit_s =",
            "time_limit =",
            "'time_limit'; did you mean 'time_limit_s'?",
        ),
        ("mass_kg =", "mas_kg =", "'mas_kg'; did you mean 'mass_kg'?"),
        (
            "settle_s =",
            "setle_s =",
            "'setle_s'; did you mean 'settle_s'?",
        ),
    ];
    for (from, to, expected) in cases {
        let error = refused(from, to);
        let place = format!("cells/x.toml:{}: unknown key", line_with(from));
        assert!(
            error.starts_with(&place) && error.contains(expected),
            "{error}"
        );
    }
}

#[test]
fn numbers_out_of_range_name_line_key_value_and_range() {
    let cases = [
        (
            "mass_kg = 0.1",
            "mass_kg = -0.1",
            "object.0.mass_kg is -0.1; 0.001 to 100 is allowed",
        ),
        (
            "mass_kg = 0.1",
            "mass_kg = nan",
            "object.0.mass_kg is nan; a finite number is needed",
        ),
        (
            "time_limit_s = 120.0",
            "time_limit_s = inf",
            "time_limit_s is inf; a finite number",
        ),
        (
            "grip_force_n = 20.0",
            "grip_force_n = 0.0",
            "task.grip_force_n is 0; 0.1 to 10000",
        ),
        ("friction = 0.9", "friction = 9.0", "object.0.friction is 9"),
        (
            "-0.5686",
            "-9.5686",
            "arm.0.home_joint_positions.1 is -9.5686; -1.7628 to 1.7628",
        ),
    ];
    for (from, to, expected) in cases {
        let error = refused(from, to);
        let place = format!("cells/x.toml:{}: ", line_with(from));
        assert!(
            error.starts_with(&place) && error.contains(expected),
            "{error}"
        );
    }
}

#[test]
fn names_have_to_lead_somewhere_and_be_unique() {
    let cases = [
        (
            r#"["red_cube", "blue_cube""#,
            r#"["red_cub", "blue_cube""#,
            "did you mean 'red_cube'?",
        ),
        (
            r#"["red_cube", "blue_cube""#,
            r#"["red_cube", "red_cube""#,
            "is in a stack once",
        ),
        (
            r#"name = "blue_cube""#,
            r#"name = "red_cube""#,
            "that name is taken",
        ),
        (
            r#"name = "blue_cube""#,
            r#"name = "Blue cube""#,
            "a-z, 0-9 and _",
        ),
        (
            r#"default_policy = "fsm""#,
            r#"default_policy = "fms""#,
            "did you mean 'fsm'?",
        ),
        (
            r#"robot = "panda""#,
            r#"robot = "pnda""#,
            "cells/x.toml:21: arm.0.robot is 'pnda'; no such robot",
        ),
    ];
    for (from, to, expected) in cases {
        let error = refused(from, to);
        assert!(error.contains(expected), "{error}\nexpected {expected}");
    }
}

#[test]
fn a_pyramid_needs_a_part_for_every_arm_and_cubes_that_exist() {
    let text = Data::checkout().read("cells/franka-pyramid.toml").unwrap();
    let cases = [
        (
            "[task.robot.left]",
            "[task.robot.lft]",
            "did you mean 'left'?",
        ),
        (
            "[\"cube_1\", \"cube_2\"",
            "[\"cube_1\", \"cube_1\"",
            "is in a stack once",
        ),
        (
            "[\"cube_1\", \"cube_2\"",
            "[\"cube_1\", \"cub_2\"",
            "did you mean 'cube_2'?",
        ),
        (
            "required_count = 3",
            "required_count = 4",
            "2 arms need 8 objects, the cell has 6",
        ),
        (
            "franka-pyramid.tree.json",
            "../secret.json",
            ".json file in cells/",
        ),
        (
            "board = \"shared\"",
            "board = \"\"",
            "task.robot.left.board is ''",
        ),
        (
            "yaw_rad = 1.5708\n",
            "yaw_rad = 15.7\n",
            "task.robot.left.yaw_rad is 15.7",
        ),
        ("reach_m = 0.72", "reach_m = 0.0", "task.reach_m is 0"),
        (
            "stretched_reach_m = 0.79",
            "stretched_reach_m = 0.7",
            "it is not less than reach_m, 0.72",
        ),
    ];
    for (from, to, expected) in cases {
        let error = refused_in(&text, from, to);
        assert!(error.contains(expected), "{error}\nexpected {expected}");
        assert!(error.starts_with("cells/x.toml:"), "{error}");
    }
    let silent = text.split("[task.robot.right]").next().unwrap();
    let error = error_of("x.toml", silent);
    assert!(error.contains("silent about arm 'right'"), "{error}");
}

#[test]
fn broken_syntax_names_its_line() {
    let error = refused("time_limit_s = 120.0", "time_limit_s = = 120.0");
    assert!(
        error.starts_with(&format!("cells/x.toml:{}: ", line_with("time_limit_s"))),
        "{error}"
    );
    let deep = format!("a = {}1{}", "[".repeat(100_000), "]".repeat(100_000));
    let error = Cell::from_text(&Data::checkout(), "x", "x.toml", &deep, 0, None).unwrap_err();
    assert!(error.to_string().starts_with("x.toml"), "{error}");
}

#[test]
fn an_unknown_kind_of_task_is_answered_with_the_right_one() {
    let error = refused("kind = \"stack\"", "kind = \"stak\"");
    assert!(error.contains("did you mean 'stack'?"), "{error}");
}

#[test]
fn steps_of_palletizing_that_cannot_be_meant_are_refused_with_their_line() {
    let data = Data::checkout();
    let text = data.read("cells/ur10-palletize.toml").unwrap();
    let cases = [
        (
            "pick = [\"WaitForBin\"",
            "pick = [\"WaitForBn\"",
            "task.sequences.pick.0 is 'WaitForBn'; no such step in [task.steps]; did you mean \
             'WaitForBin'?",
        ),
        (
            "[task.steps.WaitAtBin]\nwait_s = 1.0",
            "[task.steps.WaitAtBin]",
            "task.steps.WaitAtBin is without an end; a step needs 'go', 'wait_s' or 'suction'",
        ),
        (
            "\"OpenSuctionGripper\", \"WaitAfterRelease\"",
            "\"WaitAfterRelease\"",
            "task.sequences.flip is a sequence that keeps the bin; a step with suction = \"off\"",
        ),
        (
            "\"CloseSuctionGripper\", \"LiftFromBelt\"",
            "\"LiftFromBelt\"",
            "task.sequences.pick_flipped is a sequence that takes no bin; a step with suction",
        ),
        (
            "by_m = 0.5, lead_m = 0.08",
            "by_m = 5.0, lead_m = 0.08",
            "task.steps.LiftToClearance.go.to.up.by_m is 5; 0 to 1 is allowed",
        ),
        (
            "to = { jig = {} }",
            "to = { jag = {} }",
            "unknown variant `jag`",
        ),
    ];
    for (from, to, expected) in cases {
        let error = refused_in(&text, from, to);
        assert!(error.starts_with("cells/x.toml:"), "{error}");
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_demo_counts_the_bins_that_it_accepts() {
    let read = |demo: &str| {
        Data::checkout()
            .read(&format!("cells/{demo}.toml"))
            .unwrap()
    };
    let text = read("ur10-bin-stack");
    for (from, to, words) in [
        (
            "count = 36",
            "count = 50",
            "task.bins is 50 bins; 9 columns of 4 levels have 36 places",
        ),
        (
            "levels = 4",
            "levels = 3",
            "task.bins is 36 bins; 9 columns of 3 levels have 27 places",
        ),
    ] {
        let why = refused_in(&text, from, to);
        assert!(
            why.starts_with("cells/x.toml:") && why.contains(words),
            "{why}"
        );
    }
    // Those that `--bins` leaves out do not count.
    let fifty = text.replacen("count = 36", "count = 50", 1);
    let mut cell = Cell::from_text(&Data::checkout(), "x", "x.toml", &fifty, 0, None).unwrap();
    cell.limit_bins(36).unwrap();
    assert!(demos::policies().task(&cell, &cell.default_policy).is_ok());
}

#[test]
fn a_robot_that_cannot_do_the_job_of_a_demo_is_refused() {
    for (demo, words) in [
        (
            "franka-stack",
            "'panda' cannot grip 'red_cube': it has no gripper",
        ),
        ("franka-pyramid", "'left' cannot grip"),
        ("cube", "'panda' cannot grip 'cube': it has no gripper"),
        ("ur10-palletize", "no suction gripper"),
    ] {
        let mut cell = Cell::load(&Data::checkout(), demo, 0, None).unwrap();
        (cell.arms[0].robot.gripper, cell.arms[0].robot.suction) = (None, None);
        let why = demos::policies().task(&cell, &cell.default_policy).err();
        let why = why.map(|why| why.to_string()).unwrap_or_default();
        assert!(why.contains(words), "{demo}: {why}");
    }
    for (from, to) in [
        (
            "stack_position_m = [0.55, 0.20]",
            "stack_position_m = [0.02, 0.0]",
        ),
        ("base_height_m = 0.025", "base_height_m = 0.9"),
    ] {
        let why = refused(from, to);
        assert!(why.contains("gets no nearer than"), "{why}");
    }
}
