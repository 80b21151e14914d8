//! Whatever a person gets wrong: one clear error, the documented exit code,
//! nothing started.

use std::io::Write as _;
use std::path::Path;
use std::process::Command;

use robocell_tests::assert::{nothing_started, refused};
use robocell_tests::cell::base;
use robocell_tests::program::{Said, finish, robocell};

/// `robocell ARGUMENTS` that has to be refused before anything is started.
fn refuse(arguments: &[&str], code: i32, words: &[&str]) -> Said {
    let base = base();
    let said = finish(robocell(base.path(), arguments));
    refused(&said, code, words);
    nothing_started(base.path());
    said
}

#[test]
fn an_unknown_demo_is_answered_with_the_near_one() {
    refuse(&["run", "franka-stak"], 3, &["franka-stak", "franka-stack"]);
    refuse(
        &["eval", "franka-stak", "--seeds", "1..2"],
        3,
        &["franka-stack"],
    );
}

#[test]
fn an_unknown_policy_is_answered_with_the_near_one() {
    refuse(
        &["run", "franka-stack", "--policy", "ifels"],
        3,
        &["ifels", "did you mean 'ifelse'?"],
    );
    refuse(
        &["run", "franka-stack", "--one-process", "--policy", "x"],
        3,
        &["fsm, ifelse"],
    );
}

#[test]
fn a_wrong_command_line_is_usage() {
    refuse(&["run"], 2, &["DEMO"]);
    refuse(&["runn"], 2, &["run"]);
    refuse(&["run", "franka-stack", "--sped", "1"], 2, &["--speed"]);
    refuse(&["run", "franka-stack", "--speed", "fast"], 2, &["max"]);
    refuse(
        &["run", "franka-stack", "--timeout", "nan"],
        2,
        &["--timeout"],
    );
    refuse(
        &["run", "franka-stack", "--timeout", "-1"],
        2,
        &["more than 0"],
    );
    refuse(&["run", "franka-stack", "--cell", "../x"], 2, &["letters"]);
    refuse(
        &["run", "franka-stack", "--xrdf", "a.xrdf"],
        2,
        &["--robot"],
    );
    refuse(&["target", "0.1", "nan", "0.2"], 2, &["finite"]);
    refuse(&["target", "0.1", "0.1", "0.1", "0.2"], 2, &["roll"]);
}

#[test]
fn a_missing_file_is_named() {
    refuse(
        &["run", "franka-stack", "--script", "/no/such.jsonl"],
        3,
        &["/no/such.jsonl"],
    );
    refuse(
        &["run", "reach", "--robot", "/no/arm.urdf"],
        3,
        &["/no/arm.urdf"],
    );
    refuse(
        &["run", "franka-stack", "--data", "/no/data"],
        3,
        &["/no/data"],
    );
}

#[test]
fn a_bad_script_is_named_with_its_line() {
    let dir = base();
    let path = dir.path().join("s.jsonl");
    let file = path.to_str().unwrap();
    for (text, words) in [
        (
            "{\"at_s\": 1, \"do\": \"pause\"}\n{\"at_s\": 1, \"do\": \"dragg\"}",
            ["s.jsonl:2", "dragg"],
        ),
        (
            "{\"at_s\": 1, \"do\": \"drag\", \"object\": \"blue_cub\", \"to\": [0, 0, 0]}",
            ["blue_cub", "blue_cube"],
        ),
        ("{\"at_s\": -3, \"do\": \"pause\"}", ["s.jsonl:1", "at_s"]),
    ] {
        std::fs::write(&path, text).unwrap();
        refuse(&["run", "franka-stack", "--script", file], 3, &words);
    }
}

/// The shipped data with one line of a file changed.
fn data_with(dir: &Path, file: &str, from: &str, to: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for folder in ["cells", "cells/cube", "robots/panda"] {
        std::fs::create_dir_all(dir.join(folder)).unwrap();
        for entry in std::fs::read_dir(root.join(folder)).unwrap().flatten() {
            if entry.path().is_file() {
                std::fs::copy(entry.path(), dir.join(folder).join(entry.file_name())).unwrap();
            }
        }
    }
    let text = std::fs::read_to_string(dir.join(file)).unwrap();
    assert!(text.contains(from), "{file} has no {from:?}");
    std::fs::write(dir.join(file), text.replacen(from, to, 1)).unwrap();
}

fn refuse_cell(from: &str, to: &str, words: &[&str]) {
    let dir = base();
    data_with(dir.path(), "cells/franka-stack.toml", from, to);
    refuse(
        &[
            "run",
            "franka-stack",
            "--data",
            dir.path().to_str().unwrap(),
        ],
        3,
        words,
    );
}

#[test]
fn a_typo_in_a_cell_file_is_answered_with_the_near_key() {
    refuse_cell(
        "clearance_m",
        "clearence_m",
        &["franka-stack.toml", "clearence_m", "clearance_m"],
    );
}

#[test]
fn nan_in_a_cell_file_is_named_with_its_key() {
    refuse_cell(
        "clearance_m = 0.1",
        "clearance_m = nan #",
        &["franka-stack.toml", "clearance_m", "nan"],
    );
}

#[test]
fn broken_toml_is_named_with_its_line() {
    refuse_cell("[task]", "[task", &["franka-stack.toml"]);
}

#[test]
fn objects_that_start_in_one_another_are_named_once() {
    let base = base();
    let data = base.path().join("data");
    data_with(
        &data,
        "cells/cube.toml",
        "# Not an obstacle",
        "[[object]]\nname = \"second\"\nshape = { kind = \"box\", size_m = [0.3, 0.3, 0.05] }\n\
         mass_kg = 0.1\nfriction = 0.9\nposition_m = [0.50, -0.25, 0.025]\n\
         colour = [0.1, 0.1, 0.8]\n\n# Not an obstacle",
    );
    let data = data.display().to_string();
    let said = finish(robocell(
        base.path(),
        &["run", "cube", "--data", &data, "--headless", "--until-done"],
    ));
    assert_eq!(said.code, 3, "{said:?}");
    let named = said.stderr.matches("object 'second' starts").count();
    assert_eq!(named, 1, "{said:?}");
    for word in ["started again", "given up", "last words", "-proc"] {
        assert!(!said.stderr.contains(word), "{said:?}");
    }
}

fn refuse_urdf(text: &str, words: &[&str]) {
    let dir = base();
    let path = dir.path().join("arm.urdf");
    std::fs::write(&path, text).unwrap();
    refuse(
        &["run", "reach", "--robot", path.to_str().unwrap()],
        3,
        words,
    );
}

#[test]
fn a_urdf_that_nests_20000_deep_is_refused() {
    let text = format!(
        "<robot name=\"a\">{}{}</robot>",
        "<x>".repeat(20_000),
        "</x>".repeat(20_000)
    );
    refuse_urdf(&text, &["arm.urdf", "nesting", "64"]);
}

#[test]
fn a_urdf_whose_joints_form_a_circle_is_refused() {
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>"
        )
    };
    let text = format!(
        "<robot name=\"a\"><link name=\"a\"/><link name=\"b\"/>{}{}</robot>",
        joint("j1", "a", "b"),
        joint("j2", "b", "a")
    );
    refuse_urdf(&text, &["arm.urdf"]);
}

#[test]
fn an_empty_or_cut_urdf_is_refused() {
    for text in [
        "",
        "<robot name=\"a\">",
        "\u{0}\u{1}\u{2}",
        "<robot name=\"a\"></robot>",
    ] {
        refuse_urdf(text, &["arm.urdf"]);
    }
}

#[test]
fn a_stack_out_of_reach_is_refused_with_its_line() {
    let data = base();
    let path = data.path().to_str().unwrap();
    let [from, to] = ["[0.55, 0.20]", "[2.45, 0.2]"].map(|at| format!("stack_position_m = {at}"));
    data_with(data.path(), "cells/franka-stack.toml", &from, &to);
    refuse(
        &["run", "franka-stack", "--data", path],
        3,
        &[
            "franka-stack.toml:79",
            "stack_position_m",
            "[2.45, 0.2]",
            "2.46 m from the base of",
        ],
    );
}

#[test]
fn what_an_arm_cannot_do_is_refused_in_every_mode_by_the_same_sentence() {
    let size = "size_m = [0.05, 0.05, 0.05]";
    let mark = "[task.place.mark]\nposition_m = [0.50, 0.25, 0.0]";
    let wide = size.replace("0.05", "0.09");
    let high = mark.replace("[0.50, 0.25, 0.0]", "[0.55, 0.2, 0.72]");
    for (from, to, sentence) in [
        (
            size,
            wide,
            "arm 'panda' cannot grip 'cube': it opens its hand 0.080 m wide",
        ),
        (
            mark,
            high,
            "no arm reaches it: 'panda' gets no nearer than 0.078 m",
        ),
    ] {
        let (data, base) = (base(), base());
        data_with(data.path(), "cells/cube.toml", from, &to);
        for policy in ["ifelse", "tree", "json", "table", "matrix"] {
            let common = [
                "cube",
                "--policy",
                policy,
                "--data",
                data.path().to_str().unwrap(),
            ];
            for mode in [
                &["run", "--headless"][..],
                &["run", "--one-process"],
                &["eval", "--seeds", "1..2"],
            ] {
                let said = finish(robocell(base.path(), &[mode, &common[..]].concat()));
                refused(&said, 3, &[sentence]);
            }
        }
        nothing_started(base.path());
    }
}

#[test]
fn an_object_that_is_out_of_reach_at_the_start_is_a_warning_in_every_mode() {
    let (data, base) = (base(), base());
    let [near, far] = ["[0.50, -0.25, 0.025]", "[0.50, -1.25, 0.025]"];
    data_with(data.path(), "cells/cube.toml", near, far);
    let common = [
        "cube",
        "--policy",
        "json",
        "--data",
        data.path().to_str().unwrap(),
    ];
    // The task does not end in one second; `eval` ends well when all rows are written.
    let modes: [(&[&str], i32); 3] = [
        (&["run", "--headless", "--speed", "max", "--until-done"], 5),
        (&["run", "--one-process", "--headless", "--until-done"], 5),
        (&["eval", "--seeds", "1..1"], 0),
    ];
    for (mode, code) in modes {
        let arguments = [mode, &common[..], &["--timeout", "1"]].concat();
        let said = finish(robocell(base.path(), &arguments));
        refused(
            &said,
            code,
            &["warning: panda cannot pick cube at", "move it nearer"],
        );
    }
}

#[test]
fn what_needs_a_running_cell_says_that_there_is_none() {
    for arguments in [
        ["status"].as_slice(),
        &["top"],
        &["down"],
        &["pause"],
        &["resume"],
        &["step", "5"],
        &["reset"],
        &["task", "pause"],
        &["restart", "task"],
        &["gripper", "open"],
        &["target", "0.4", "-0.1", "0.3"],
        &["drag", "red_cube", "--to", "0.4", "-0.1", "0.03"],
        &["logs"],
    ] {
        refuse(arguments, 4, &["no cell `cell` is running", "robocell run"]);
    }
}

#[test]
fn a_recording_that_cannot_be_made_is_refused_before_anything_starts() {
    let base = base();
    let files = tempfile::tempdir().unwrap();
    let at = |name: &str| files.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(at("there.mcap"), "x").unwrap();
    std::fs::create_dir(at("folder.mcap")).unwrap();
    std::os::unix::fs::symlink(at("there.mcap"), at("link.mcap")).unwrap();
    for (file, words) in [
        (at("there.mcap"), "exists already"),
        (at("folder.mcap"), "directory"),
        (at("link.mcap"), "link"),
        ("/dev/null".to_owned(), "device"),
        (at("missing/a.mcap"), "missing"),
    ] {
        let arguments = ["run", "franka-stack", "--headless", "--record", &file];
        refused(
            &finish(robocell(base.path(), &arguments)),
            3,
            &[words, &file[..8]],
        );
    }
    nothing_started(base.path());
    assert_eq!(std::fs::read_to_string(at("there.mcap")).unwrap(), "x");
}

#[test]
fn a_file_argument_that_does_not_end_is_refused() {
    let files = tempfile::tempdir().unwrap();
    let at = |name: &str| files.path().join(name).to_str().unwrap().to_owned();
    let fifo = at("fifo");
    let made = Command::new("mkfifo").arg(&fifo).status().unwrap();
    assert!(made.success());
    std::fs::write(at("large"), vec![b' '; 5 << 20]).unwrap();
    let inputs = [
        (fifo.as_str(), "pipe"),
        ("/dev/zero", "a device"),
        (&at("large"), "more than"),
        ("/", "a directory"),
    ];
    for (file, word) in inputs {
        for arguments in [
            ["run", "cube", "--script", file].as_slice(),
            &["run", "cube", "--one-process", "--script", file],
            &["eval", "cube", "--seeds", "1", "--script", file],
            &["run", "reach", "--robot", file],
            &["bt", "check", file],
            &["fsm", "check", file],
            &["eval", "report", file],
            &["eval", "merge", file],
        ] {
            if word != "more than" || arguments[1] != "report" && arguments[1] != "merge" {
                refuse(arguments, 3, &[file, word]);
            }
        }
        if word != "more than" && word != "a directory" {
            refuse(&["plot", file, "x"], 3, &[file, word]);
            refuse(&["replay", file], 3, &[file, word]);
        }
    }
    let outputs = [
        ["eval", "cube", "--seeds", "1", "--out"].as_slice(),
        &["eval", "report", &at("rows"), "--html"],
    ];
    std::fs::write(at("rows"), "").unwrap();
    for output in outputs {
        for file in ["/dev/full", &fifo] {
            refuse(&[output, &[file]].concat(), 3, &[file]);
        }
    }
}

#[test]
fn a_pipe_with_a_writer_is_read() {
    let base = base();
    let mut command = robocell(base.path(), &["bt", "check", "/dev/stdin"]);
    let tree = "{\"format\": \"behavior-tree/1\", \"name\": \"x\"}";
    command.stdin(piped(tree));
    let said = finish(command);
    refused(&said, 3, &["/dev/stdin", "root"]);
}

/// A pipe from which `text` is read.
fn piped(text: &str) -> std::io::PipeReader {
    let (reader, mut writer) = std::io::pipe().unwrap();
    writer.write_all(text.as_bytes()).unwrap();
    reader
}

#[test]
fn what_stands_in_the_way_of_a_project_is_named() {
    let base = base();
    std::os::unix::fs::symlink("nowhere", base.path().join("job")).unwrap();
    let mut command = robocell(base.path(), &["new", "job", "--as", "json"]);
    command.current_dir(base.path());
    let said = finish(command);
    refused(&said, 3, &["job exists"]);
}
