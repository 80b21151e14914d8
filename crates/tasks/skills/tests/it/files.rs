//! Jobs in files: errors are refused when the file is loaded, with line and column, and do not
//! stop a run later.

use std::path::PathBuf;

use cell_model::{Cell, Data};
use robocell_skills::with_file_jobs;
use robocell_task::Policies;

/// A folder that is removed with it.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

/// The error of a cell with that `[task]` and that behaviour file.
fn said(test: &str, kind: &str, file: &str, text: &str) -> Result<(), String> {
    said_of_cell(test, kind, (file, text), ("", ""))
}

/// As [`said`], of a cell file with one change.
fn said_of_cell(
    test: &str,
    kind: &str,
    (file, text): (&str, &str),
    change: (&str, &str),
) -> Result<(), String> {
    let dir = std::env::temp_dir().join(format!("robocell-skills-{test}-{}", std::process::id()));
    let folder = Folder(dir);
    std::fs::create_dir_all(folder.0.join("cells")).unwrap();
    let cell = Data::checkout()
        .read("cells/cube.toml")
        .unwrap()
        .into_owned();
    let head = format!("kind = \"{kind}\"\nbehaviour = \"{file}\"");
    let cell = cell
        .replace("kind = \"cube\"", &head)
        .replace("\"matrix\"]", "\"matrix\", \"machine\"]")
        .replacen(change.0, change.1, 1);
    std::fs::write(folder.0.join("cells/mine.toml"), cell).unwrap();
    std::fs::write(folder.0.join("cells").join(file), text).unwrap();
    let data = Data::dir(folder.0.clone()).with_robots_of(&Data::checkout());
    let cell = Cell::load(&data, "mine", 0, None).unwrap();
    let policies = with_file_jobs(Policies::new());
    let task = policies.task(&cell, kind);
    task.map(|_| ()).map_err(|error| error.to_string())
}

fn example(name: &str) -> String {
    let text = Data::checkout().read(&format!("cells/cube/cube.{name}"));
    text.unwrap().into_owned()
}

/// `text` with one change is refused, and the error names `expected`.
fn refused(
    test: &str,
    kind: &str,
    file: &str,
    text: &str,
    change: (&str, &str),
    expected: &[&str],
) {
    assert!(text.contains(change.0), "{}", change.0);
    let text = text.replacen(change.0, change.1, 1);
    let error = said(test, kind, file, &text).expect_err(change.1);
    for words in expected {
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn the_examples_are_taken() {
    for (kind, name) in [
        ("tree", "tree.json"),
        ("machine", "machine.toml"),
        ("matrix", "matrix.toml"),
    ] {
        let taken = said("taken", kind, &format!("a.{name}"), &example(name));
        assert_eq!(taken, Ok(()), "{kind}");
    }
}

#[test]
fn a_state_that_nothing_leaves_is_refused() {
    let text = example("machine.toml");
    let machine = |change, expected: &[&str]| {
        refused("machine", "machine", "a.toml", &text, change, expected);
    };
    machine(
        (
            "name = \"done\"\nfinal = true",
            "name = \"done\"\n\n[[states]]\nname = \"forgotten\"",
        ),
        &[
            "cells/a.toml:39:",
            "nothing leaves state 'forgotten'",
            "during.steps",
        ],
    );
    // Its steps never end, and no event has a row.
    machine(("during.success = \"retracted\"\n", ""), &["'retracted'"]);
    machine(
        ("held = { do = \"Holding\"", "held = { do = \"Pick\""),
        &["'held' asks 'Pick', which is not a condition"],
    );
    let steps = text.split("name = \"retracting\"").nth(1).unwrap();
    let steps = steps.split("during.steps = ").nth(1).unwrap();
    let steps = steps.split("\n]").next().unwrap();
    let retracting = format!("during.steps = {steps}\n]\n\n[[states]]\nname = \"done\"");
    let empty = "during.steps = []\n\n[[states]]\nname = \"done\"";
    machine((&retracting, empty), &["'retracting' has no steps"]);
}

#[test]
fn a_state_whose_last_step_gives_the_job_up_needs_no_row() {
    let lost = "{ do = \"Home\" }, { do = \"FailJob\", reason = \"cube_lost\" }";
    let state = format!("[[states]]\nname = \"lost\"\nduring.steps = [{lost}]\n\n[events]");
    let machine = example("machine.toml").replacen("[events]", &state, 1);
    assert_eq!(said("gives_up", "machine", "a.toml", &machine), Ok(()));
    let first = machine.replace(
        lost,
        &lost.replace("FailJob\", reason = \"cube_lost", "Open"),
    );
    let error = said("goes_on", "machine", "a.toml", &first).unwrap_err();
    assert!(error.contains("FailJob as its last step"), "{error}");
    let matrix = example("matrix.toml").replacen(
        "\"RETRACTING\", {",
        &format!("\"RETRACTING\", {{ name = \"LOST\", during.steps = [{lost}] }}, {{"),
        1,
    );
    assert_eq!(said("gives_up_too", "matrix", "a.toml", &matrix), Ok(()));
}

#[test]
fn the_policy_of_a_file_has_one_name_and_takes_the_one_of_earlier_builds() {
    let cell = |kind: &str| {
        let dir =
            std::env::temp_dir().join(format!("robocell-named-{kind}-{}", std::process::id()));
        let folder = Folder(dir);
        std::fs::create_dir_all(folder.0.join("cells")).unwrap();
        let cell = Data::checkout().read("cells/cube.toml").unwrap();
        let list = cell
            .lines()
            .find(|line| line.starts_with("policies"))
            .unwrap();
        let cell = cell
            .replace(list, &format!("policies = [\"{kind}\"]"))
            .replace("\"ifelse\"", &format!("\"{kind}\""))
            .replace(
                "kind = \"cube\"",
                &format!("kind = \"{kind}\"\nbehaviour = \"cube/cube.tree.json\""),
            );
        std::fs::write(folder.0.join("cells/mine.toml"), cell).unwrap();
        let data = Data::dir(folder.0.clone()).with_robots_of(&Data::checkout());
        let cell = Cell::load(&data, "mine", 0, None).unwrap();
        (cell.policies.join(" "), cell.default_policy)
    };
    assert_eq!(cell("tree"), ("json".to_owned(), "json".to_owned()));
    assert_eq!(cell("machine"), ("table".to_owned(), "table".to_owned()));
    assert_eq!(cell("matrix"), ("matrix".to_owned(), "matrix".to_owned()));
    let known = ["json", "table"];
    let named = |asked| cell_model::runs::policy_name::policy_named(asked, &known);
    assert_eq!(
        (named("tree"), named("machine")),
        (Some("json"), Some("table"))
    );
    let code = cell_model::runs::policy_name::policy_named("json", &["tree"]);
    assert_eq!(code, None, "a tree in code is not a file");
}

#[test]
fn a_misspelt_step_is_refused_with_the_name_that_was_meant() {
    let text = example("machine.toml");
    let machine = |change, expected: &[&str]| {
        refused("steps", "machine", "a.toml", &text, change, expected);
    };
    machine(
        (
            "{ do = \"Close\", object = \"cube\" }",
            "{ do = \"Clos\", object = \"cube\" }",
        ),
        &["cells/a.toml:14:", "'Clos'", "did you mean 'Close'?"],
    );
    machine(
        (
            "{ do = \"Close\", object = \"cube\" }",
            "{ do = \"Close\", object = \"cub\" }",
        ),
        &[
            "cells/a.toml:14:",
            "unknown object 'cub'",
            "did you mean 'cube'?",
        ],
    );
    machine(
        (
            "place = \"mark\", above_m = 0.1",
            "place = \"mark\", abov_m = 0.1",
        ),
        &["a.toml:", "did you mean 'above_m'?"],
    );
    machine(
        ("by_m = 0.1", "by_m = 9.0"),
        &["port 'by_m' is 9", "allowed is 0 to 2"],
    );
    machine(
        ("unless = \"on_mark\"", "unless = \"onmark\""),
        &["onmark", "did you mean 'on_mark'?"],
    );
    machine(
        ("trigger = \"released\"", "trigger = \"relesed\""),
        &["relesed", "did you mean 'released'?"],
    );
    machine(
        ("{ do = \"Open\" },", "{ open = true },"),
        &["a step is a table with do"],
    );
    machine(
        (
            "during.success = \"gripped\"",
            "during.run = \"grip\"\nduring.success = \"gripped\"",
        ),
        &["'run' and 'steps'"],
    );
}

#[test]
fn a_way_that_the_cell_does_not_have_is_refused() {
    let text = example("machine.toml");
    let machine = |change, expected: &[&str]| {
        refused("way", "machine", "a.toml", &text, change, expected);
    };
    let above = "place = \"mark\", above_m = 0.1";
    machine(
        (above, "place = \"mark\", ignore = \"tabel\", above_m = 0.1"),
        &[
            "cells/a.toml:",
            "no obstacle has a name that starts with 'tabel'",
        ],
    );
    machine(
        (
            above,
            "place = \"mark\", approach = [0.0, 1.0], above_m = 0.1",
        ),
        &["'approach' has 2 numbers; 3 are needed"],
    );
}

#[test]
fn a_handler_without_steps_and_an_event_that_nothing_raises_are_refused() {
    let text = example("matrix.toml");
    let matrix = |change, expected: &[&str]| {
        refused("matrix", "matrix", "a.toml", &text, change, expected);
    };
    matrix(
        ("\"LOST\"]", "\"LOST\", \"TIMEOUT\"]"),
        &["a.toml:9:", "nothing raises event 'TIMEOUT'"],
    );
    matrix(
        ("\"RETRACTING\", {", "\"RETRACTING\", \"FORGOTTEN\", {"),
        &["state 'FORGOTTEN' answers no event"],
    );
    matrix(("LOST = \"fetch\"", "LOST = \"search\""), &["'search'"]);
    matrix(
        ("success = \"RETRACTED\"", "success = \"RETRACTD\""),
        &["'RETRACTD'", "did you mean 'RETRACTED'?"],
    );
    matrix(
        ("[handlers.stay]\nsteps", "[handlers.stay]\nstep"),
        &["no key 'step'", "'stay' has no steps"],
    );
}

#[test]
fn a_tree_names_its_objects_and_places() {
    let text = example("tree.json");
    let tree = |change, expected: &[&str]| {
        refused("tree", "tree", "a.json", &text, change, expected);
    };
    tree(
        ("\"place\": \"mark\"", "\"place\": \"marc\""),
        &[
            "cells/a.json:10:",
            "unknown place 'marc'",
            "did you mean 'mark'?",
        ],
    );
    tree(
        ("\"object\": \"cube\", \"above_m\": 0.1", "\"above_m\": 0.1"),
        &["needs an 'object'"],
    );
}

#[test]
fn a_place_that_no_arm_reaches_is_refused() {
    let text = example("tree.json");
    let place = |table: &str| {
        let change = ("[task.place.mark]\nposition_m = [0.50, 0.25, 0.0]", table);
        said_of_cell("far", "tree", ("a.json", &text), change)
    };
    let error = place("[task.place.mark]\nposition_m = [1.5, 0.25, 0.0]").unwrap_err();
    for part in [
        "mine.toml:",
        "task.place.mark.position_m is [1.500, 0.250, 0.000] in slot 0",
        "'panda' reaches 0.79 m",
        "it is 1.52 m from its base",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let row = "pattern = { kind = \"grid\", count = [1, 9, 1], pitch_m = [0.1, 0.1, 0.1] }";
    let table = format!("[task.place.mark]\nposition_m = [0.5, 0.0, 0.0]\n{row}");
    let error = place(&table).unwrap_err();
    assert!(error.contains("in slot 7"), "{error}");
}

#[test]
fn a_state_runs_a_tree_in_a_file_beside_it() {
    let text = example("machine.toml");
    let start = text.find("during.success = \"gripped\"").unwrap();
    let end = text.find("[[states]]\nname = \"carrying\"").unwrap();
    let nested = format!(
        "{}during.success = \"gripped\"\nduring.run = \"fetch.tree.json\"\n\n{}",
        &text[..start],
        &text[end..]
    );
    let error = said("nested", "machine", "a.toml", &nested).unwrap_err();
    assert!(error.contains("fetch.tree.json"), "{error}");
    let other = nested.replace("fetch.tree.json", "fetch");
    let error = said("nested", "machine", "a.toml", &other).unwrap_err();
    assert!(error.contains("runs 'fetch', which is not here"), "{error}");
}

/// The warnings at the start of a cell whose tree is that node with these ports.
fn warnings(test: &str, node: &str) -> Vec<String> {
    let dir = std::env::temp_dir().join(format!("robocell-warn-{test}-{}", std::process::id()));
    let folder = Folder(dir);
    std::fs::create_dir_all(folder.0.join("cells")).unwrap();
    let cell = Data::checkout().read("cells/cube.toml").unwrap();
    let cell = cell.replace("kind = \"cube\"", "kind = \"tree\"\nbehaviour = \"a.json\"");
    let tree = format!(
        r#"{{"format": "behavior-tree/1", "name": "t", "blackboard": {{"local": {{
            "what": {{"type": "text", "default": "cub"}}}}}}, "root": {{"id": "n", {node}}}}}"#
    );
    std::fs::write(folder.0.join("cells/mine.toml"), cell).unwrap();
    std::fs::write(folder.0.join("cells/a.json"), tree).unwrap();
    let data = Data::dir(folder.0.clone()).with_robots_of(&Data::checkout());
    let cell = Cell::load(&data, "mine", 0, None).unwrap();
    let task = with_file_jobs(Policies::new()).task(&cell, "json").unwrap();
    task.warnings().to_vec()
}

#[test]
fn what_is_odd_about_a_port_is_said_at_the_start() {
    let to = |pose: &str| format!(r#""type": "MoveTo", "ports": {{"pose": {pose}}}"#);
    for (test, node, words) in [
        (
            "far",
            to("[500, 0, 0.3]"),
            "'pose' is 500.00 m from the base of panda",
        ),
        (
            "zeros",
            to("[0.5, 0, 0.3, 0, 0, 0, 0]"),
            "a quaternion of zeros",
        ),
        (
            "long",
            to("[0.5, 0, 0.3, 0, 2, 0, 0]"),
            "has the length 2.000",
        ),
        (
            "beside",
            r#""type": "MoveTo", "ports": {"object": "cube", "pose": [0.5, 0, 0.3]}"#.to_owned(),
            "'pose' is not used beside 'object'",
        ),
        (
            "default",
            r#""type": "MoveTo", "ports": {"object": {"bb": "local.what"}}"#.to_owned(),
            "starts with 'cub': unknown object; did you mean 'cube'?",
        ),
    ] {
        let said = warnings(test, &node);
        assert_eq!(said.len(), 1, "{test}: {said:?}");
        assert!(
            said[0].starts_with("node 'n': ") && said[0].contains(words),
            "{said:?}"
        );
    }
    assert_eq!(warnings("good", &to("[0.5, 0, 0.3, 0, 1, 0, 0]")), [""; 0]);
}

#[test]
fn a_step_may_be_a_loop_over_objects() {
    let text = example("machine.toml");
    let step = "{ do = \"Close\", object = \"cube\" }";
    let each = |object: &str| {
        text.replacen(
            step,
            &format!(
                "{{ do = \"ForEach\", as = \"it\", items = [\"{object}\"], children = [{{ do = \
                 \"Close\", object = \"${{it}}\" }}] }}"
            ),
            1,
        )
    };
    assert_eq!(said("loop", "machine", "a.toml", &each("cube")), Ok(()));
    let error = said("loops", "machine", "a.toml", &each("cubes")).unwrap_err();
    assert!(error.contains("unknown object 'cubes'"), "{error}");
}
