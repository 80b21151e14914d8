//! SIGKILL of physics at random instants of a whole job, as `robocell chaos --kills` does
//! it: a short sample. CONTRIBUTING has the long series.

use std::fmt::Write as _;
use std::path::Path;

use robocell_tests::cell::base;
use robocell_tests::program::Said;

use crate::outputs::checked;

/// What the exit code and each kill of the report have to say.
fn check(said: &Said, kills: usize) {
    assert_eq!(said.code, 0, "{said:?}");
    let report = said.json();
    for what in ["jobs_failed", "parts_lost", "leftovers", "kills_missing"] {
        assert_eq!(report[what], 0, "{what}: {report}");
    }
    let done = report["kills"].as_array().unwrap();
    assert_eq!(done.len(), kills, "{report}");
    for kill in done {
        assert_eq!(kill["process"], "physics", "{report}");
        assert!(kill["job"].as_u64().unwrap() > 1, "{report}");
        let lost = kill["ticks_lost"].as_u64().unwrap();
        assert!(lost <= 1000 && lost <= kill["tick"].as_u64().unwrap());
        assert!(kill["back_ms"].as_f64().unwrap() > 0.0, "{report}");
    }
}

fn chaos(dir: &Path, words: &[&str]) -> Said {
    let all = [&["chaos", "--process", "physics", "--json"], words].concat();
    checked(dir, "chaos", &all)
}

#[test]
fn lose_a_second_at_most_and_no_part_in_real_time_and_in_lockstep() {
    let base = base();
    let words = ["cube", "--kills", "1", "--seed", "3"];
    check(&chaos(base.path(), &words), 1);
    let words = ["cube", "--kills", "3", "--seed", "4", "--speed", "max"];
    check(&chaos(base.path(), &words), 3);
}

#[test]
fn lose_a_second_at_most_where_the_state_grows_with_the_contacts_of_a_pile() {
    let base = base();
    let data = data(base.path(), "tub", &tub());
    let words = ["tub", "--data", &data, "--kills", "2", "--speed", "max"];
    check(&chaos(base.path(), &words), 2);
}

#[test]
fn that_were_not_possible_are_no_success() {
    let base = base();
    // The job is never done, so that its length is not known.
    let short = one_policy().replace("time_limit_s = 90.0", "time_limit_s = 1.0");
    let data = data(base.path(), "short", &short);
    let words = ["short", "--data", &data, "--kills", "1", "--speed", "max"];
    let said = chaos(base.path(), &words);
    assert_eq!(said.code, 5, "{said:?}");
    assert_eq!(said.json()["kills_missing"], 1, "{said:?}");
    assert!(said.stderr.contains("1 kill is missing"), "{said:?}");
}

/// A folder for `--data` with one cell.
fn data(base: &Path, name: &str, text: &str) -> String {
    let cells = base.join("data/cells");
    std::fs::create_dir_all(&cells).unwrap();
    std::fs::write(cells.join(format!("{name}.toml")), text).unwrap();
    base.join("data").display().to_string()
}

/// The cell `cube` without the policies that are files.
fn one_policy() -> String {
    let lists = "policies = [\"ifelse\", \"fsm\", \"tree\", \"json\", \"table\", \"matrix\"]";
    let cube = include_str!("../../../cells/cube.toml");
    cube.replace(lists, "policies = [\"ifelse\"]")
}

/// The cell `cube`, with boxes that fall into a tub: at rest, the state of physics is
/// several times as long as at the start.
fn tub() -> String {
    let cube = one_policy();
    let (head, task) = cube.split_once("[task]").unwrap();
    let mut text = format!(
        "{head}[[object]]\nname = \"box\"\ncount = 50\npitch_m = [0.0, 0.0, 0.06]\n\
         shape = {{ kind = \"box\", size_m = [0.045, 0.045, 0.045] }}\nmass_kg = 0.05\n\
         friction = 0.6\nposition_m = [-0.4, 0.6, 0.1]\n\
         spawn = {{ x_m = 0.02, y_m = 0.02, yaw_rad = 0.8 }}\ncolour = [0.3, 0.3, 0.8]\n"
    );
    let walls = [
        ([0.3, 0.02, 0.5], [-0.4, 0.46]),
        ([0.3, 0.02, 0.5], [-0.4, 0.74]),
        ([0.02, 0.3, 0.5], [-0.54, 0.6]),
        ([0.02, 0.3, 0.5], [-0.26, 0.6]),
    ];
    for (index, (size_m, [x, y])) in walls.iter().enumerate() {
        write!(
            text,
            "[[fixture]]\nname = \"wall_{index}\"\n\
             shape = {{ kind = \"box\", size_m = {size_m:?} }}\nposition_m = [{x}, {y}, 0.25]\n\
             friction = 0.6\nobstacle = false\ncolour = [0.5, 0.5, 0.5]\n"
        )
        .unwrap();
    }
    format!("{text}[task]{task}")
}
