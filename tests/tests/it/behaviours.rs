//! Behaviours from the outside: shown, checked, edited and swapped.

use std::path::{Path, PathBuf};

use robocell_tests::cell::{TestCell, base, generation};
use robocell_tests::program::{Said, finish, robocell, wait_for};

fn checkout() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn ask(arguments: &[&str]) -> Said {
    finish(robocell(base().path(), arguments))
}

fn path(name: &str) -> String {
    checkout().join(name).display().to_string()
}

#[test]
fn a_policy_is_shown_as_text_mermaid_and_dot() {
    let show = |format| {
        let said = ask(&[
            "bt",
            "show",
            "franka-stack",
            "--policy",
            "bt",
            "--format",
            format,
        ]);
        assert_eq!(said.code, 0, "{said:?}");
        said.stdout
    };
    let text = show("text");
    assert_eq!(text.lines().count(), 26, "{text}");
    for (format, text) in [("text", &text), ("mermaid", &show("mermaid"))] {
        let of = |kind: &str| text.matches(kind).count();
        assert!(
            text.contains("StackBelowBroken (condition)"),
            "{format}: {text}"
        );
        assert_eq!(
            (of("(condition)"), of("(action)")),
            (3, 17),
            "{format}: {text}"
        );
    }
    let fsm = ask(&["fsm", "show", "franka-stack", "--policy", "fsm"]);
    assert!(fsm.stdout.contains("PRE_GRASP"), "{fsm:?}");
    let table = ask(&[
        "fsm",
        "show",
        &path("crates/core/behavior/examples/palletizing.toml"),
    ]);
    assert!(table.stdout.contains("needs_flip"), "{table:?}");
}

#[test]
fn a_matrix_is_shown_as_the_table_it_was_written_as() {
    let said = ask(&["fsm", "show", "ur10-fill-bin", "--policy", "matrix"]);
    let lines: Vec<&str> = said.stdout.lines().collect();
    let words = |line: &str| {
        line.split_whitespace()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(
        lines.first().map(|line| words(line)),
        Some(
            ["STANDBY", "PICKING", "ATTACH", "HOLDING"]
                .map(str::to_owned)
                .to_vec()
        ),
        "{said:?}"
    );
    let row = |event: &str| lines.iter().position(|line| line.starts_with(event));
    let start = row("START").expect("a row");
    assert_eq!(words(lines[start]), ["START", "to_above_bin"], "{said:?}");
    assert_eq!(words(lines[start + 1]), ["→", "PICKING"], "{said:?}");
    // The order of precedence.
    assert!(row("STOP") < row("DETACHED") && row("DETACHED") < row("GOAL_REACHED"));
}

#[test]
fn conditions_of_a_tree_in_a_file_are_shown_as_such() {
    for (file, condition, action) in [
        (
            "cells/cube/cube.tree.json",
            "on the mark (condition At)",
            "let go (Open)",
        ),
        (
            "cells/franka-pyramid.tree.json",
            "complete already (condition CheckStackComplete)",
            "acquire (AcquireCube)",
        ),
    ] {
        let show = |format| ask(&["bt", "show", &path(file), "--format", format]).stdout;
        let text = show("text");
        assert!(text.contains(condition) && text.contains(action), "{text}");
        let mermaid = show("mermaid");
        assert!(
            mermaid.contains(&format!("{{{{\"{condition}\"}}}}")),
            "{mermaid}"
        );
        assert!(mermaid.contains(&format!("[\"{action}\"]")), "{mermaid}");
    }
}

#[test]
fn the_files_of_the_demos_have_no_errors() {
    for (kind, file) in [
        ("bt", "cells/franka-pyramid.tree.json"),
        ("bt", "cells/cube/cube.tree.json"),
        ("fsm", "cells/cube/cube.machine.toml"),
        ("fsm", "cells/cube/cube.matrix.toml"),
        ("fsm", "crates/core/behavior/examples/palletizing.toml"),
        ("fsm", "crates/core/behavior/examples/fill_bin.toml"),
        ("fsm", "crates/core/behavior/examples/bin_stacking.toml"),
    ] {
        let said = ask(&[kind, "check", &path(file)]);
        assert_eq!(said.code, 0, "{said:?}");
        assert!(said.stdout.contains("no errors"), "{said:?}");
    }
}

#[test]
fn every_mistake_of_a_tree_is_named_with_its_place() {
    let dir = base();
    let file = dir.path().join("broken.json");
    let text = r#"{
  "format": "behavior-tree/1", "name": "broken",
  "root": {"id": "a", "type": "Sequenze", "children": [
    {"id": "b", "type": "SetGripper", "ports": {"command": "ajar"}},
    {"id": "b", "type": "Wait", "ports": {"seconds": "long"}}
  ]}
}"#;
    std::fs::write(&file, text).expect("the file is written");
    let said = ask(&["bt", "check", &file.display().to_string()]);
    assert_eq!(said.code, 3, "{said:?}");
    for part in ["broken.json:3:", "did you mean 'Sequence'?"] {
        assert!(said.stderr.contains(part), "no {part}: {}", said.stderr);
    }
    let missing = ask(&["bt", "check", "no-such-file.json"]);
    assert_eq!(missing.code, 3);
    assert!(missing.stderr.contains("no-such-file.json"), "{missing:?}");
}

#[test]
fn editors_get_a_schema_of_every_kind_of_file() {
    for (kind, word) in [
        ("tree", "MoveToTarget"),
        ("machine", "precedence"),
        ("cell", "grip_force_n"),
    ] {
        let said = ask(&["schema", kind]);
        assert_eq!(said.code, 0, "{said:?}");
        let schema: serde_json::Value = serde_json::from_str(&said.stdout).expect("JSON");
        assert!(schema["$schema"].is_string(), "{kind}");
        assert!(said.stdout.contains(word), "{kind} does not know {word}");
    }
}

#[test]
fn a_running_tree_is_printed_with_its_statuses() {
    let cell = TestCell::start(&["franka-stack", "--policy", "bt", "--headless"]);
    cell.wait_up();
    let frame = wait_for("a frame with a running phase", || {
        let said = cell.ask(&["bt", "show", "--live", "--once"]);
        (said.code == 0 && said.stdout.contains("Normal")).then_some(said.stdout)
    });
    assert!(frame.lines().count() >= 26, "{frame}");
    let top = wait_for("the active node", || {
        let said = cell.ask(&["top"]);
        said.stdout.contains("active: ").then_some(said.stdout)
    });
    assert!(top.contains("bt: running"), "{top}");
}

/// The file is read again with every start of the task; nodes whose ids stay
/// keep their state.
#[test]
fn an_edited_tree_is_taken_over_in_the_middle_of_a_job() {
    let dir = base();
    let data = dir.path().join("data");
    copy(&checkout().join("cells"), &data.join("cells"));
    copy(&checkout().join("robots"), &data.join("robots"));
    let file = data.join("cells/franka-pyramid.tree.json");
    let data = data.display().to_string();
    let script = dir.path().join("pause.jsonl");
    // Simulated time is paused while the file is edited, with a cube on its way.
    std::fs::write(&script, r#"{"at_s": 4.0, "do": "pause"}"#).expect("the script is written");
    let script = script.display().to_string();
    let mut cell = TestCell::start_in(
        dir,
        &[
            "franka-pyramid",
            "--data",
            &data,
            "--headless",
            "--speed",
            "max",
            "--until-done",
            "--json",
            "--script",
            &script,
        ],
    );
    cell.wait_status("the pause", |status| status["paused"] == true);
    let text = std::fs::read_to_string(&file).expect("the tree");
    // One more node, and another name for an old one.
    let retract = r#"{"id": "retract", "type": "MoveToTarget", "name": "retract""#;
    let breathe = r#"{"id": "breathe", "type": "Wait", "ports": {"seconds": 0.2}},
               {"id": "retract", "type": "MoveToTarget", "name": "go up""#;
    let edited = text.replacen(retract, breathe, 1);
    assert_ne!(edited, text);
    std::fs::write(&file, edited).expect("the tree is edited");
    let said = cell.ask(&["restart", "task"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert_eq!(cell.ask(&["resume"]).code, 0);
    let said = cell.wait_end();
    assert_eq!(said.code, 0, "{said:?}");
    let summary = said.json();
    assert_eq!(
        summary["placed"].as_array().map(Vec::len),
        Some(6),
        "{summary}"
    );
    assert_eq!(summary["task_restarts"], 1, "{summary}");
    assert_eq!(
        (&summary["drops"], &summary["recoveries"]),
        (&0.into(), &0.into()),
        "{summary}"
    );
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).expect("a file is copied");
        }
    }
}

/// A task that would not start is not started: the one that works is kept.
#[test]
fn a_broken_edit_is_refused_and_the_running_task_left_alone() {
    let dir = base();
    let data = dir.path().join("data");
    copy(&checkout().join("cells"), &data.join("cells"));
    copy(&checkout().join("robots"), &data.join("robots"));
    let file = data.join("cells/franka-pyramid.tree.json");
    let text = std::fs::read_to_string(&file).expect("the tree");
    let data = data.display().to_string();
    let run = ["franka-pyramid", "--data", &data, "--headless", "--paused"];
    let cell = TestCell::start_in(dir, &run);
    let before = cell.wait_up();
    std::fs::write(&file, text.replace("MoveToTarget", "MoveToTargt")).expect("it is broken");
    let said = cell.ask(&["restart", "task"]);
    assert_eq!(said.code, 3, "{said:?}");
    for part in ["did you mean 'MoveToTarget'?", "left alone"] {
        assert!(said.stderr.contains(part), "{said:?}");
    }
    let after = cell.wait_up();
    assert_eq!(generation(&after, "task"), generation(&before, "task"));
    // Nor does a cell begin with it.
    let other = cell.ask(&["run", "franka-pyramid", "--data", &data, "--cell", "other"]);
    assert_eq!(other.code, 3, "{other:?}");
    assert!(other.stderr.contains("did you mean"), "{other:?}");
}

const FOREIGN: &str = r#"<root BTCPP_format="4"><include path="sub/b.xml"/><BehaviorTree ID="A">
  <Sequence><Say text="hello"/><SubTree ID="B"/></Sequence></BehaviorTree></root>"#;

#[test]
fn a_tree_of_behaviortree_cpp_is_imported_and_checked() {
    let base = base();
    let at = |name: &str| base.path().join(name).display().to_string();
    std::fs::create_dir(at("sub")).expect("a folder");
    std::fs::write(at("a.xml"), FOREIGN).expect("a file");
    let b = FOREIGN
        .replace("<include path=\"sub/b.xml\"/>", "")
        .replace("\"A\"", "\"B\"");
    let b = b.replace("<SubTree ID=\"B\"/>", "<Switch2/>");
    std::fs::write(at("sub/b.xml"), &b).expect("a file");
    let import = ["bt", "import", &at("a.xml"), "--tree", "A"];
    let refused = finish(robocell(base.path(), &import));
    assert_eq!(refused.code, 3, "{refused:?}");
    assert!(
        refused.stderr.contains("b.xml:2:32: Switch2"),
        "{refused:?}"
    );
    assert_eq!(refused.stdout, "");
    std::fs::write(at("sub/b.xml"), b.replace("Switch2", "Think")).expect("a file");
    let imported = finish(robocell(base.path(), &import));
    assert_eq!(imported.code, 0, "{imported:?}");
    assert!(
        imported.stderr.contains("Say (action, first in"),
        "{imported:?}"
    );
    std::fs::write(at("a.tree.json"), &imported.stdout).expect("a file");
    let checked = finish(robocell(base.path(), &["bt", "check", &at("a.tree.json")]));
    assert_eq!(checked.code, 0, "{checked:?}");
    let missing = finish(robocell(base.path(), &["bt", "import", &at("none.xml")]));
    assert_eq!(missing.code, 3, "{missing:?}");
}
