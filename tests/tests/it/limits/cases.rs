//! A command for each limit that is checked at load, with one more than the limit.

use std::fmt::Write as _;
use std::path::Path;

use robocell_tests::program::{Said, finish, robocell};

/// Loads one more than `limit` in a directory.
type Case = fn(&Path, usize) -> Said;

const CUBE: &str = include_str!("../../../../cells/cube.toml");
const STACK: &str = include_str!("../../../../cells/franka-stack.toml");
const BINS: &str = include_str!("../../../../cells/ur10-bin-stack.toml");
const PALLET: &str = include_str!("../../../../cells/ur10-palletize.toml");

const ARM: &str = "\n[[arm]]\nname = \"arm#\"\nrobot = \"panda\"\nbase_position_m = [#.0, 0.0, 0.0]\n\
    home_joint_positions = [0.012, -0.5686, 0.0, -2.8102, 0.0, 3.0366, 0.741]\n";
const FIXTURE: &str = "\n[[fixture]]\nname = \"f#\"\nshape = { kind = \"box\", size_m = [0.1, 0.1, 0.1] }\n\
    position_m = [#.0, 3.0, 0.05]\nfriction = 0.9\nobstacle = false\ncolour = [0.5, 0.5, 0.5]\n";
const OBJECTS: &str = "\n[[object]]\nname = \"o\"\ncount = #\npitch_m = [0.1, 0.0, 0.0]\n\
    shape = { kind = \"box\", size_m = [0.04, 0.04, 0.04] }\nmass_kg = 0.1\nfriction = 0.9\n\
    position_m = [-9.0, 3.0, 0.02]\ncolour = [0.5, 0.5, 0.5]\n";
const SENSOR: &str = "\n[[sensor]]\nname = \"s#\"\nposition_m = [0.0, 0.0, 0.0]\n\
    direction = [1.0, 0.0, 0.0]\nrange_m = 1.0\n";

pub(super) fn all() -> Vec<(&'static str, Case)> {
    let mut all = cells();
    all.extend(jobs());
    all.extend(robots());
    all.extend(runs());
    all.extend(trees());
    all.extend(tree_files());
    all.extend(machines());
    all.extend(matrices());
    all
}

fn robot(dir: &Path, arguments: &[&str]) -> Said {
    let runs = dir.join("runs");
    std::fs::create_dir_all(&runs).expect("a directory");
    finish(robocell(&runs, arguments))
}

fn written(dir: &Path, name: &str, text: &str) -> String {
    let path = dir.join(name);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    std::fs::write(&path, text).expect("a file");
    path.display().to_string()
}

/// Runs the cell of that text.
fn cell(dir: &Path, text: &str) -> Said {
    let data = dir.join("data");
    written(&data, "cells/large.toml", text);
    let data = data.display().to_string();
    robot(
        dir,
        &[
            "run",
            "large",
            "--data",
            &data,
            "--headless",
            "--one-process",
        ],
    )
}

/// `text` as often as `count`, numbered.
fn times(text: &str, count: usize) -> String {
    (1..=count)
        .map(|n| text.replace('#', &n.to_string()))
        .collect()
}

/// `text` with the line that starts with `key` replaced.
fn with(text: &str, key: &str, line: &str) -> String {
    let replaced = text
        .lines()
        .map(|l| if l.starts_with(key) { line } else { l });
    replaced.collect::<Vec<_>>().join("\n")
}

fn names(count: usize) -> String {
    let names: Vec<String> = (0..count).map(|n| format!("\"n{n}\"")).collect();
    names.join(", ")
}

fn cells() -> Vec<(&'static str, Case)> {
    vec![
        ("ipc-types/src/lib.rs::MAX_ARMS", |dir, limit| {
            cell(dir, &format!("{CUBE}{}", times(ARM, limit)))
        }),
        ("ipc-types/src/lib.rs::MAX_OBJECTS", |dir, limit| {
            cell(
                dir,
                &format!("{CUBE}{}", OBJECTS.replace('#', &limit.to_string())),
            )
        }),
        (
            "crates/core/cell-model/src/cells/check_file.rs::MAX_OBSTACLE_OBJECTS",
            |dir, limit| {
                let objects = OBJECTS.replace('#', &(limit + 1).to_string());
                cell(dir, &format!("{CUBE}{objects}obstacle = true\n"))
            },
        ),
        (
            "crates/core/cell-model/src/cells/check_file.rs::MAX_FIXTURES",
            |dir, limit| cell(dir, &format!("{CUBE}{}", times(FIXTURE, limit))),
        ),
        (
            "crates/core/cell-model/src/cells/check_file.rs::MAX_POLICIES",
            |dir, limit| {
                let line = format!("policies = [\"ifelse\", {}]", names(limit));
                cell(dir, &with(CUBE, "policies", &line))
            },
        ),
        (
            "crates/core/cell-model/src/cells/cell/camera.rs::MAX_CAMERAS",
            |dir, limit| {
                let camera = |at| {
                    format!("\n[cameras.more_{at}]\neye_m = [1, 1, 1]\ntarget_m = [0, 0, 0]\n")
                };
                let more: String = (0..=limit).map(camera).collect();
                cell(dir, &format!("{CUBE}{more}"))
            },
        ),
        (
            "crates/core/cell-model/src/cells/cell/camera.rs::MAX_PIXELS",
            |dir, limit| {
                let camera = format!(
                    "\n[cameras.large]\neye_m = [1, 1, 1]\ntarget_m = [0, 0, 0]\nsize = [64, {}]\n",
                    limit + 1
                );
                cell(dir, &format!("{CUBE}{camera}"))
            },
        ),
        ("ipc-types/src/equipment.rs::MAX_SENSORS", |dir, limit| {
            cell(dir, &format!("{CUBE}{}", times(SENSOR, limit + 1)))
        }),
        (
            "crates/core/cell-model/src/user_file.rs::MAX_FILE_BYTES",
            |dir, limit| cell(dir, &format!("{CUBE}#{}", "x".repeat(limit))),
        ),
    ]
}

fn jobs() -> Vec<(&'static str, Case)> {
    vec![
        (
            "crates/tasks/skills/src/settings/place.rs::MAX_SLOTS",
            |dir, limit| {
                let grid = format!(
                    "pattern = {{ kind = \"grid\", count = [{}, 1, 1], pitch_m = [0.1, 0.1, 0.1] }}\n",
                    limit + 1
                );
                cell(dir, &format!("{CUBE}\n{grid}"))
            },
        ),
        (
            "crates/tasks/demos/src/check.rs::MAX_STACK",
            |dir, limit| {
                let objects = OBJECTS.replace('#', &(limit + 1).to_string());
                let order: Vec<String> = (1..=limit + 1).map(|n| format!("\"o_{n:02}\"")).collect();
                let order = format!("order = [{}]", order.join(", "));
                cell(dir, &format!("{}{objects}", with(STACK, "order", &order)))
            },
        ),
        (
            "crates/tasks/demos/src/palletize/numbers.rs::MAX_SLOTS",
            |dir, limit| {
                let x: Vec<String> = (0..=limit)
                    .map(|n| format!("{:.2}", 0.01 * n as f64))
                    .collect();
                let text = with(
                    PALLET,
                    "slot_x_m",
                    &format!("slot_x_m = [{}]", x.join(", ")),
                );
                cell(dir, &with(&text, "slot_y_m", "slot_y_m = [0.0]"))
            },
        ),
        (
            "crates/tasks/demos/src/bin_stack/columns.rs::MAX_LEVELS",
            |dir, limit| {
                cell(
                    dir,
                    &with(BINS, "levels", &format!("levels = {}", limit + 1)),
                )
            },
        ),
    ]
}

#[test]
fn bins_that_have_no_place_are_refused_with_both_numbers() {
    let dir = robocell_tests::cell::base();
    let said = cell(dir.path(), &with(BINS, "count", "count = 50"));
    assert_eq!(said.code, 3, "{said:?}");
    for word in ["50 bins", "36 places", "--bins"] {
        assert!(said.stderr.contains(word), "{word}: {said:?}");
    }
}

fn urdf(dir: &Path, text: &str) -> Said {
    let file = written(dir, "arm.urdf", text);
    robot(
        dir,
        &[
            "run",
            "reach",
            "--robot",
            &file,
            "--headless",
            "--one-process",
        ],
    )
}

/// A URDF of so many joints, one after the other.
fn chain(joints: usize, kind: &str, more: &str) -> String {
    let mut text = "<robot name=\"r\"><link name=\"l0\"/>".to_owned();
    for n in 1..=joints {
        write!(
            text,
            "<link name=\"l{n}\"/><joint name=\"j{n}\" type=\"{kind}\"><parent link=\"l{}\"/>\
             <child link=\"l{n}\"/><origin xyz=\"0 0 0.02\"/>{more}</joint>",
            n - 1
        )
        .expect("text");
    }
    text + "</robot>"
}

fn robots() -> Vec<(&'static str, Case)> {
    vec![
        (
            "crates/core/cell-model/src/robots/urdf_check.rs::MAX_LINKS",
            |dir, limit| urdf(dir, &chain(limit, "fixed", "")),
        ),
        (
            "crates/core/cell-model/src/robots/urdf_scan.rs::MAX_DEPTH",
            |dir, limit| {
                let (open, close) = ("<a>".repeat(limit), "</a>".repeat(limit));
                urdf(dir, &format!("<robot name=\"r\">{open}{close}</robot>"))
            },
        ),
        (
            "crates/core/cell-model/src/robots/urdf_scan.rs::MAX_BYTES",
            |dir, limit| {
                urdf(
                    dir,
                    &format!("<robot name=\"r\">{}</robot>", " ".repeat(limit)),
                )
            },
        ),
        ("crates/core/rmp/src/chain.rs::MAX_JOINTS", |dir, limit| {
            let axis = "<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"9\" velocity=\"1\"/>";
            urdf(dir, &chain(limit + 1, "revolute", axis))
        }),
    ]
}

fn runs() -> Vec<(&'static str, Case)> {
    vec![
        (
            "crates/core/cell-model/src/cells/script.rs::MAX_LINES",
            |dir, limit| {
                let lines = "{\"at_s\": 900.0, \"do\": \"reset\"}\n".repeat(limit + 1);
                let script = written(dir, "a.jsonl", &lines);
                let run = ["run", "cube", "--script", &script];
                robot(dir, &[&run[..], &["--headless", "--one-process"]].concat())
            },
        ),
        (
            "crates/core/cell-model/src/cells/script.rs::MAX_PARTS",
            |dir, limit| {
                let line = format!(
                    "{{\"at_s\": 1.0, \"do\": \"drop_parts\", \"count\": {}}}\n",
                    limit + 1
                );
                let script = written(dir, "a.jsonl", &line);
                let run = ["run", "ur10-fill-bin", "--script", &script];
                robot(dir, &[&run[..], &["--headless", "--one-process"]].concat())
            },
        ),
        (
            "crates/core/cell-model/src/cells/sweep/mod.rs::MAX_VARIANTS",
            |dir, limit| {
                let values: Vec<String> = (0..=limit).map(|n| format!("0.{:06}", n + 1)).collect();
                let set = format!("object.0.mass_kg={}", values.join(","));
                robot(dir, &["eval", "cube", "--seeds", "1..1", "--set", &set])
            },
        ),
        (
            "crates/cell/evaluation/src/shard.rs::MAX_SHARDS",
            |dir, limit| {
                let shard = format!("1/{}", limit + 1);
                robot(dir, &["eval", "cube", "--seeds", "1..2", "--shard", &shard])
            },
        ),
        (
            "crates/cell/cell-bus/src/site.rs::MAX_LENGTH",
            |dir, limit| {
                let long = dir.join("x".repeat(limit));
                std::fs::create_dir_all(&long).expect("a directory");
                finish(robocell(&long, &["run", "cube", "--headless"]))
            },
        ),
    ]
}

/// `bt check` of a tree file with that root and those members besides.
fn tree(dir: &Path, root: &str, besides: &str) -> Said {
    let text =
        format!("{{\"format\": \"behavior-tree/1\", \"name\": \"t\"{besides}, \"root\": {root}}}");
    robot(dir, &["bt", "check", &written(dir, "t.json", &text)])
}

const LEAF: &str = r#"{"id": "n#", "type": "Open", "name": "n"}"#;

fn leaves(count: usize) -> String {
    let leaves: Vec<String> = (0..count)
        .map(|n| LEAF.replace('#', &n.to_string()))
        .collect();
    format!(
        r#"{{"id": "root", "type": "Sequence", "name": "r", "children": [{}]}}"#,
        leaves.join(", ")
    )
}

fn trees() -> Vec<(&'static str, Case)> {
    vec![
        (
            "crates/core/behavior/src/tree/mod.rs::MAX_NODES",
            |dir, limit| tree(dir, &leaves(limit), ""),
        ),
        (
            "crates/core/behavior/src/tree/mod.rs::MAX_DEPTH",
            |dir, limit| {
                // Children inside one another would exceed the nesting of JSON first.
                let modifiers = vec![r#"{"type": "Inverter"}"#; limit + 1].join(", ");
                let root = LEAF.replace('}', &format!(r#", "modifiers": [{modifiers}]}}"#));
                tree(dir, &root, "")
            },
        ),
        (
            "crates/core/behavior/src/descriptor/limits.rs::MAX_FILES",
            |dir, limit| {
                for n in 1..=limit {
                    let besides = format!(", \"includes\": [\"f{}.json\"]", n + 1);
                    let text =
                        format!("{{\"format\": \"behavior-tree/1\", \"name\": \"t\"{besides}}}");
                    written(dir, &format!("f{n}.json"), &text);
                }
                tree(dir, LEAF, ", \"includes\": [\"f1.json\"]")
            },
        ),
        (
            "crates/core/behavior/src/descriptor/limits.rs::MAX_ENTRIES",
            |dir, limit| {
                let all: Vec<String> = (0..=limit).map(|n| format!("\"c{n}\": {n}")).collect();
                tree(
                    dir,
                    LEAF,
                    &format!(", \"constants\": {{{}}}", all.join(", ")),
                )
            },
        ),
        (
            "crates/core/behavior/src/descriptor/limits.rs::MAX_PORTS",
            |dir, limit| {
                let all: Vec<String> = (0..=limit).map(|n| format!("\"p{n}\": {n}")).collect();
                let ports = all.join(", ");
                let root =
                    format!(r#"{{"id": "n", "type": "Open", "name": "n", "ports": {{{ports}}}}}"#);
                tree(dir, &root, "")
            },
        ),
        (
            "crates/core/behavior/src/descriptor/limits.rs::MAX_NAME",
            |dir, limit| tree(dir, &LEAF.replace('#', &"x".repeat(limit)), ""),
        ),
    ]
}

fn tree_files() -> Vec<(&'static str, Case)> {
    vec![
        (
            "crates/core/behavior/src/descriptor/limits.rs::MAX_TEXT",
            |dir, limit| {
                let name = "x".repeat(limit + 1);
                tree(
                    dir,
                    &format!(r#"{{"id": "n", "type": "Open", "name": "{name}"}}"#),
                    "",
                )
            },
        ),
        (
            "crates/core/behavior/src/descriptor/json.rs::MAX_BYTES",
            |dir, limit| tree(dir, &format!("{LEAF}{}", " ".repeat(limit)), ""),
        ),
        (
            "crates/core/behavior/src/descriptor/json.rs::MAX_DEPTH",
            |dir, limit| {
                tree(
                    dir,
                    &format!("{}{}", "[".repeat(limit), "]".repeat(limit)),
                    "",
                )
            },
        ),
        (
            "crates/core/behavior/src/value.rs::STR_BYTES",
            |dir, limit| {
                let text = "x".repeat(limit + 1);
                tree(
                    dir,
                    LEAF,
                    &format!(", \"constants\": {{\"c\": \"{text}\"}}"),
                )
            },
        ),
        (
            "crates/core/behavior/src/value.rs::MAX_NUMBERS",
            |dir, limit| {
                let numbers = vec!["1.0"; limit + 1].join(", ");
                let root = format!(
                    r#"{{"id": "n", "type": "MoveTo", "name": "n", "ports": {{"posture": [{numbers}]}}}}"#
                );
                tree(dir, &root, "")
            },
        ),
    ]
}

fn machine(dir: &Path, text: &str) -> Said {
    let file = written(dir, "m.machine.toml", text);
    robot(dir, &["fsm", "check", &file])
}

fn states(count: usize) -> String {
    let states = "[[states]]\nname = \"s#\"\n";
    format!(
        "version = 1\nname = \"m\"\ninitial = \"s1\"\n{}",
        times(states, count)
    )
}

const ROW: &str = "[[rows]]\ntrigger = \"t#\"\nsource = \"s1\"\ndest = \"s2\"\n";

fn nested(depth: usize) -> String {
    let mut inner = "{ name = \"s\" }".to_owned();
    for _ in 0..depth {
        inner = format!("{{ name = \"s\", initial = \"s\", children = [{inner}] }}");
    }
    format!("version = 1\nname = \"m\"\ninitial = \"s\"\nstates = [{inner}]\n")
}

fn machines() -> Vec<(&'static str, Case)> {
    vec![
        (
            "crates/core/behavior/src/machine/set.rs::MAX_MEMBERS",
            |dir, limit| machine(dir, &states(limit + 1)),
        ),
        (
            "crates/core/behavior/src/machine/compile/states.rs::MAX_DEPTH",
            |dir, limit| machine(dir, &nested(limit + 1)),
        ),
        (
            "crates/core/behavior/src/machine/read/machine.rs::MAX_DEPTH",
            |dir, limit| machine(dir, &nested(limit + 1)),
        ),
        (
            "crates/core/behavior/src/machine/compile/mod.rs::MAX_ROWS",
            |dir, limit| {
                let rows = ROW.replace('#', "").repeat(limit + 1);
                machine(dir, &format!("{}{rows}", states(2)))
            },
        ),
        (
            "crates/core/behavior/src/machine/compile/mod.rs::MAX_TRIGGERS",
            |dir, limit| machine(dir, &format!("{}{}", states(2), times(ROW, limit + 1))),
        ),
        (
            "crates/core/behavior/src/machine/read/fields.rs::MAX_NAME",
            |dir, limit| {
                let name = "x".repeat(limit + 1);
                machine(
                    dir,
                    &format!("{}[[states]]\nname = \"{name}\"\n", states(2)),
                )
            },
        ),
    ]
}

fn matrices() -> Vec<(&'static str, Case)> {
    vec![
        (
            "crates/core/behavior/src/matrix/ids.rs::MAX_EVENTS",
            |dir, limit| {
                let event = "n# = { do = \"Holding\", object = \"cube\" }\n";
                let text = format!(
                    "version = 1\nname = \"m\"\nstates = [\"A\"]\ninitial = \"A\"\n\
                 precedence = [{}]\n[events]\n{}",
                    names(limit + 1),
                    times(event, limit + 1)
                );
                let file = written(dir, "m.matrix.toml", &text);
                robot(dir, &["fsm", "check", &file])
            },
        ),
        (
            "crates/core/behavior/src/matrix/ids.rs::MAX_HANDLERS",
            |dir, limit| {
                let handler = "h#.steps = [{ do = \"Stay\" }]\n";
                let text = format!(
                    "version = 1\nname = \"m\"\nstates = [\"A\"]\ninitial = \"A\"\n\
                     precedence = [\"e\"]\n[handlers]\n{}",
                    times(handler, limit + 1)
                );
                let file = written(dir, "m.matrix.toml", &text);
                robot(dir, &["fsm", "check", &file])
            },
        ),
    ]
}
