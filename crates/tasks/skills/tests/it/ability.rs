//! A job that an arm cannot do is refused before the first decision, with object or place, arm
//! and advice.

use cell_model::{Cell, Data};
use robocell_skills::with_file_jobs;
use robocell_task::{Policies, Task};

const PICK: &str = "cube/cube.tree.json";

/// The cube's cell as a job in a tree, with one change to its file.
fn cell(from: &str, to: &str) -> Cell {
    let text = Data::checkout().read("cells/cube.toml").unwrap();
    assert!(text.contains(from), "{from}");
    let head = format!("kind = \"tree\"\nbehaviour = \"{PICK}\"");
    let text = text.replace("kind = \"cube\"", &head).replacen(from, to, 1);
    Cell::from_text(&Data::checkout(), "x", "cells/x.toml", &text, 0, None).unwrap()
}

fn task(cell: &Cell) -> Result<Task, String> {
    let policies = with_file_jobs(Policies::new());
    policies.task(cell, "tree").map_err(|why| why.to_string())
}

#[track_caller]
fn refused(cell: &Cell, words: &[&str]) {
    let why = task(cell).err().expect("it is taken");
    for word in words {
        assert!(why.contains(word), "{word}: {why}");
    }
}

#[test]
fn an_object_wider_than_the_hand_on_every_side_is_refused_with_its_line() {
    let wide = cell("[0.05, 0.05, 0.05]", "[0.12, 0.10, 0.09]");
    let words = [
        PICK,
        ":",
        "'panda' cannot grip 'cube'",
        "0.080 m wide",
        "0.090 m",
        "use another object",
    ];
    refused(&wide, &words);
    // One side is enough.
    assert!(task(&cell("[0.05, 0.05, 0.05]", "[0.12, 0.07, 0.12]")).is_ok());
}

#[test]
fn an_arm_without_a_gripper_is_refused_in_a_job_that_picks() {
    let mut bare = cell("", "");
    bare.arms[0].robot.gripper = None;
    refused(
        &bare,
        &[
            "'panda' cannot grip 'cube'",
            "has no gripper",
            "fingers or suction",
        ],
    );
}

#[test]
fn a_place_that_the_joints_do_not_reach_is_refused_with_how_near_they_get() {
    // Near enough by distance: above the base, and inside of it.
    for place in ["[0.55, 0.20, 0.72]", "[0.0, 0.0, 0.0]"] {
        let cell = cell("[0.50, 0.25, 0.0]", place);
        let words = [
            "cells/x.toml:",
            "task.place.mark.position_m",
            "in slot 0",
            "'panda' gets no nearer than",
            "move the place",
        ];
        refused(&cell, &words);
    }
    let far = cell("[0.50, 0.25, 0.0]", "[0.50, 2.25, 0.0]");
    refused(
        &far,
        &[
            "task.place.mark.position_m",
            "'panda' reaches",
            "from its base",
        ],
    );
}

#[test]
fn an_object_that_is_out_of_reach_now_is_a_warning() {
    let near = task(&cell("", "")).unwrap();
    assert_eq!(near.warnings(), [""; 0]);
    let far = task(&cell("[0.50, -0.25, 0.025]", "[0.50, -1.25, 0.025]")).unwrap();
    let [warning] = far.warnings() else {
        panic!("{:?}", far.warnings());
    };
    assert!(
        warning.starts_with("panda cannot pick cube at [0.5"),
        "{warning}"
    );
    assert!(warning.ends_with("move it nearer"), "{warning}");
}
