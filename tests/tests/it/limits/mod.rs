//! docs/limits.md: every limit is the one of the code, every capacity of the code is in
//! it, and one more of all that is refused at load is refused with the number.

mod cases;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use robocell_tests::cell::base;

fn root() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).to_owned()
}

/// A row of the tables.
struct Row {
    limit: u64,
    /// `FILE::CONST`.
    constant: String,
    beyond: String,
}

/// `1024`, `10,000`, `4 MiB`.
fn number(text: &str) -> u64 {
    let (digits, unit) = text.split_once(' ').unwrap_or((text, ""));
    let digits: u64 = digits.replace(',', "").parse().expect(text);
    match unit {
        "" => digits,
        "KiB" => digits << 10,
        "MiB" => digits << 20,
        other => panic!("{other} is not a unit of {text}"),
    }
}

fn rows() -> Vec<Row> {
    let text = std::fs::read_to_string(root().join("docs/limits.md")).expect("the document");
    let rows = text.lines().filter(|line| line.contains("::"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [_, limit, constant, reason, beyond] = cells[..] else {
            panic!("{line}");
        };
        assert!(!reason.is_empty(), "{line}");
        Row {
            limit: number(limit),
            constant: constant.trim_matches('`').to_owned(),
            beyond: beyond.to_owned(),
        }
    };
    rows.map(row).collect()
}

/// Constants of a source file that are whole numbers, as they are written.
fn constants(file: &Path) -> BTreeMap<String, String> {
    let text = std::fs::read_to_string(file).unwrap_or_else(|_| panic!("{}", file.display()));
    let declared = text.lines().filter_map(|line| {
        let at = line.trim_start();
        let (before, rest) = at.split_once("const ")?;
        let plain = before.is_empty() || before.starts_with("pub");
        let (name, rest) = rest.split_once(": ")?;
        let (kind, value) = rest.split_once(" = ")?;
        let whole = ["usize", "u16", "u32", "u64", "f64"].contains(&kind);
        (plain && whole).then(|| (name.to_owned(), value.trim_end_matches(';').to_owned()))
    });
    declared.collect()
}

/// The value of `text`: numbers, `<<`, `*` and names of the same file or of the messages.
fn value(text: &str, known: &BTreeMap<String, String>) -> u64 {
    if let Some((left, right)) = text.split_once(" << ") {
        return value(left, known) << value(right, known);
    }
    if let Some((left, right)) = text.split_once(" * ") {
        return value(left, known) * value(right, known);
    }
    let digits = text.replace('_', "");
    if let Ok(number) = digits.trim_end_matches(".0").parse() {
        return number;
    }
    let name = text.rsplit("::").next().unwrap_or(text);
    let messages = constants(&root().join("ipc-types/src/lib.rs"));
    let found = known.get(name).or_else(|| messages.get(name));
    value(found.unwrap_or_else(|| panic!("{text}")), known)
}

#[test]
fn each_limit_of_the_document_is_that_of_the_code() {
    let mut seen = BTreeSet::new();
    for row in rows() {
        assert!(seen.insert(row.constant.clone()), "{} twice", row.constant);
        let (file, name) = row.constant.rsplit_once("::").expect("FILE::CONST");
        let known = constants(&root().join(file));
        let text = known
            .get(name)
            .unwrap_or_else(|| panic!("{file} has no {name}"));
        assert_eq!(value(text, &known), row.limit, "{}", row.constant);
        let says = ["refused", "reported", "oldest replaced", "cannot be"];
        assert!(
            says.iter().any(|word| row.beyond.starts_with(word)),
            "{}: {}",
            row.constant,
            row.beyond
        );
    }
}

/// Bounds of a quantity, a search or a retry, rooms of which nothing is lost beyond them,
/// and limits that another one of the document keeps from being reached.
const NOT_CAPACITIES: [&str; 37] = [
    "controller-proc/src/planning/planner.rs::MAX_ITERATIONS",
    "controller-proc/src/planning/planner.rs::MAX_LOOKS",
    "controller-proc/src/robot_state.rs::MAX_STATE_JOINTS",
    "crates/core/behavior/src/descriptor/json.rs::KEPT",
    "crates/core/behavior/src/lines.rs::MAX_COUNTED",
    "crates/cell/cell-bus/src/gate.rs::WAITING",
    "crates/cell/cell-bus/src/qos.rs::MAX_BORROWED",
    "crates/cell/cell-bus/src/qos.rs::MAX_LOANED",
    "crates/cell/cell-bus/src/qos.rs::MAX_PUBLISHERS",
    "crates/core/cell-model/src/robots/urdf_clean/parts.rs::MAX_PREFIXES",
    "crates/core/cell-model/src/robots/movable.rs::MOST_CANDIDATES",
    "crates/cell/cell-record/src/frame.rs::MAX_PIECES",
    "crates/cell/cell-record/src/index.rs::MAX_HEADER",
    "crates/cell/cell-record/src/recording.rs::KEPT",
    "crates/cell/cell-record/src/recording.rs::MAX_BACK",
    "crates/cell/evaluation/src/charts/scale.rs::MOST_DIGITS",
    "crates/cell/supervisor/src/supervision/slot/exits.rs::MAX_CRASHES",
    "crates/cell/supervisor/src/supervision/slot/mod.rs::MAX_EXTRA_GRACE",
    "crates/cell/supervisor/src/supervision/slot/mod.rs::MAX_HUNG_STARTS",
    "crates/cell/supervisor/src/run/bus_thread.rs::MAX_GAP_NS",
    "crates/cell/supervisor/src/run/faults/starvation.rs::MAX_GAP_NS",
    "crates/core/plan/src/body.rs::MAX_JOINTS",
    "crates/core/rmp/src/resolve/exact.rs::MOST_ITERATIONS",
    "crates/tasks/skills/src/path/mod.rs::MOST_MOVES",
    "crates/tasks/task/src/goal_book.rs::MOST_GOALS",
    "crates/tasks/task/src/job.rs::MOST_COUNTED",
    "crates/tasks/task/src/reason.rs::MAX_BYTES",
    "crates/tasks/task/src/time.rs::MOST_TICKS",
    "crates/formats/tree-import/src/document/elements.rs::MAX_COUNTED",
    "crates/cell/supervisor/src/run/faults/disturbances.rs::MOST_FILLED",
    "launch/src/chaos/kills/mod.rs::MOST_TICKS_LOST",
    "launch/src/client/approach.rs::MOST_S",
    "monitor-proc/src/feed/real_time_factor.rs::MAX_SAMPLES",
    "monitor-proc/src/page/fields.rs::MAX_WHOLE",
    "physics-proc/src/arm/watchdog/mod.rs::MAX_OUTSIDE_TICKS",
    "physics-proc/src/resume/due.rs::MAX_LOST_TICKS",
    "physics-proc/src/script_report.rs::WAITING",
];
/// Files of the states that are kept, whose capacities are files on a disk.
const ELSEWHERE: [&str; 4] = [
    "crates/cell/cell-rt/src/slot/layout.rs",
    "crates/cell/task-program/src/slots/mod.rs",
    "crates/tasks/task/src/checkpoint.rs",
    "physics-proc/src/state/snapshot.rs",
];

fn is_quantity(text: &str) -> bool {
    let plain = text.replace('_', "");
    plain.parse::<f64>().is_ok() && plain.contains(['.', 'e'])
}

/// All sources but those of tests, examples and benchmarks.
fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        let skipped = [
            "target", "tests", "benches", "examples", "ui", "python", "fuzz",
        ];
        if path.is_dir() && !skipped.contains(&&*name) && !name.starts_with('.') {
            sources(&path, into);
        } else if name.ends_with(".rs") && !name.contains("tests") {
            into.push(path);
        }
    }
}

#[test]
fn each_capacity_of_the_code_is_in_the_document() {
    let listed: BTreeSet<String> = rows().into_iter().map(|row| row.constant).collect();
    let (root, mut files) = (root(), Vec::new());
    sources(&root, &mut files);
    let mut missing = Vec::new();
    for file in files {
        let name = file
            .strip_prefix(&root)
            .expect("below")
            .display()
            .to_string();
        if ELSEWHERE.contains(&name.as_str()) {
            continue;
        }
        for (constant, text) in constants(&file) {
            let capacity = ["MAX_", "MOST_", "KEPT", "WAITING"];
            let named = capacity.iter().any(|start| constant.starts_with(start));
            // A number with a point is a quantity.
            let is_one = (named || constant.ends_with("_DEPTH")) && !is_quantity(&text);
            let constant = format!("{name}::{constant}");
            if is_one && !listed.contains(&constant) && !NOT_CAPACITIES.contains(&&*constant) {
                missing.push(constant);
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn one_more_than_each_limit_is_refused_at_load_with_the_number() {
    let cases = cases::all();
    for row in rows() {
        if !row.beyond.starts_with("refused at load") {
            continue;
        }
        let case = cases.iter().find(|(constant, _)| *constant == row.constant);
        let (_, load) = case.unwrap_or_else(|| panic!("no case for {}", row.constant));
        let dir = base();
        let said = load(dir.path(), usize::try_from(row.limit).expect("a size"));
        let text = format!("{}{}", said.stdout, said.stderr);
        assert!([2, 3].contains(&said.code), "{}: {said:?}", row.constant);
        assert!(!text.contains("panicked"), "{}: {said:?}", row.constant);
        assert!(
            text.contains(&row.limit.to_string()),
            "{} is not named: {text:.2000}",
            row.constant
        );
    }
}

/// Files of capacities that depend on a kind: each has a name, as only then it is in the
/// document.
const OF_A_KIND: [(&str, &str); 2] = [
    ("ipc-types/src/topic.rs", "pub fn depth("),
    (
        "crates/cell/cell-bus/src/qos.rs",
        "pub(crate) fn max_subscribers(",
    ),
];

#[test]
fn a_capacity_that_depends_on_a_kind_has_a_name() {
    for (file, start) in OF_A_KIND {
        let text = std::fs::read_to_string(root().join(file)).expect(file);
        let at = text.find(start).expect(start);
        let body = text[at..].split("\n    }\n").next().expect("a body");
        let arms = body.lines().filter_map(|line| line.split_once(" => "));
        for (_, value) in arms {
            let value = value.trim_end_matches(',');
            // A reader that is one or two messages behind has the newest: nothing is lost.
            let is_number = value.parse::<u64>().is_ok_and(|number| number > 2);
            assert!(!is_number, "{file}: {value} has no name");
        }
    }
}
