//! The page in a real browser: what a person sees and does there. Needs
//! Chromium, Node.js and the page's packages; says so and does nothing where
//! one is missing.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::Duration;

use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::{built, finish, finish_within, robocell};
use robocell_tests::recording::rewrite;
use serde_json::{Value, json};

/// One browser at a time: without a GPU it takes the processor that the cell's
/// loops need.
static ONE: Mutex<()> = Mutex::new(());

fn ui() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../monitor-proc/ui")).to_owned()
}

/// The browser, or why there is no test.
fn browser() -> Result<PathBuf, &'static str> {
    if !ui().join("node_modules/playwright-core").is_dir() {
        return Err("the page's packages are missing: `npm ci` in monitor-proc/ui");
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let find = |name: &str| {
        std::env::split_paths(&path)
            .map(|dir| dir.join(name))
            .find(|file| file.is_file())
    };
    find("node").ok_or("Node.js is missing")?;
    find("chromium")
        .or_else(|| find("chromium-browser"))
        .or_else(|| find("google-chrome"))
        .ok_or("Chromium is missing")
}

/// Longest scenario: a person needs minutes to stack three bins.
const LONGEST: Duration = Duration::from_secs(1800);

/// Runs a scenario of `monitor-proc/ui/e2e` on a cell started with `arguments`.
#[track_caller]
fn browse(scenario: &str, arguments: &[&str]) {
    look_at(scenario, || {
        let cell = TestCell::start_with(base(), arguments, |_| {});
        cell.wait_up();
        let link = cell.link();
        (cell, link)
    });
}

/// Runs a scenario on the page that `start` starts and gives the link of.
#[track_caller]
fn look_at(scenario: &str, start: impl FnOnce() -> (TestCell, String)) {
    let _one = ONE
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    let chromium = match browser() {
        Ok(chromium) => chromium,
        Err(why) => {
            eprintln!("skipped: {why}");
            return;
        }
    };
    let (cell, link) = start();
    let mut command = Command::new("node");
    command
        .arg(ui().join("e2e/page.mjs"))
        .args([scenario, &link])
        .env("CHROMIUM", chromium)
        .env("ROBOCELL", built("robocell"))
        .env("ROBOCELL_RUN_DIR", cell.base())
        .env("OPERATOR_LINK", cell.link());
    let said = finish_within(command, LONGEST);
    assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
    eprint!("{}", said.stdout);
}

const DEMOS: [&str; 6] = [
    "franka-stack",
    "franka-pyramid",
    "reach",
    "ur10-palletize",
    "ur10-fill-bin",
    "ur10-bin-stack",
];

/// The recording of a run whose task and whose physics were killed.
fn killed_twice(base: &Path) -> PathBuf {
    let (script, file) = (base.join("kills.jsonl"), base.join("run.mcap"));
    let lines = [(2.0, "task"), (4.0, "physics")].map(|(at_s, process)| {
        json!({ "at_s": at_s, "do": "kill", "process": process }).to_string()
    });
    fs::write(&script, lines.join("\n")).unwrap();
    let (script, record) = (script.display().to_string(), file.display().to_string());
    let mut arguments = vec!["run", "franka-stack", "--headless", "--timeout", "7"];
    arguments.extend(["--script", &script, "--record", &record]);
    assert_eq!(finish(robocell(base, &arguments)).code, 5);
    file
}

/// `ROBOCELL_PAGE=all` runs the long ones too.
fn all_of_them() -> bool {
    std::env::var("ROBOCELL_PAGE").is_ok_and(|value| value == "all")
}

#[test]
#[ignore = "slow: .ci/long"]
fn each_demo_is_drawn_where_physics_has_it() {
    for demo in DEMOS {
        browse("draws", &[demo, "--paused", "--speed", "max"]);
    }
}

/// `cargo test -p robocell-tests page -- --ignored --nocapture frame_rates`
#[test]
#[ignore = "measures: for a quiet machine"]
fn frame_rates() {
    for demo in DEMOS {
        eprintln!("{demo}");
        browse("frames", &[demo, "--paused"]);
    }
    eprintln!("a tree of 10,000 nodes");
    browse_large_tree("frames", &["--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_tree_of_ten_thousand_nodes_is_folded_searched_and_updated() {
    browse_large_tree("largeTree", &[]);
}

/// Runs a scenario on a cell whose task is a tree of some 10,000 nodes: a cube is moved
/// thirty times, and beside it a hundred rows of nodes wait for a moment each.
fn browse_large_tree(scenario: &str, options: &[&str]) {
    let dir = tempfile::tempdir().unwrap();
    let made = robocell(dir.path(), &["new", "large", "--as", "json"])
        .current_dir(dir.path())
        .status()
        .unwrap();
    assert!(made.success());
    let data = dir.path().join("large");
    let tree = data.join("cells/large.tree.json");
    fs::write(tree, large_tree().to_string()).unwrap();
    let data = data.to_str().unwrap();
    browse(scenario, &[&["large", "--data", data], options].concat());
}

fn large_tree() -> Value {
    let node = |kind: &str, name: &str, ports: Value, children: Vec<Value>| {
        let id = name.replace([' ', '.'], "_");
        json!({ "id": id, "type": kind, "name": name, "ports": ports, "children": children })
    };
    let leaf = |kind: &str, name: &str, ports: Value| json!({ "id": name.replace([' ', '.'], "_"), "type": kind, "name": name, "ports": ports });
    let row = |row: u32| {
        let waits = (0..98).map(|step| {
            let seconds = 0.3 + 0.002 * f64::from(row);
            leaf(
                "Wait",
                &format!("wait {row}.{step}"),
                json!({ "seconds": seconds }),
            )
        });
        let steps = node(
            "Sequence",
            &format!("row {row}"),
            json!({}),
            waits.collect(),
        );
        node("Repeat", &format!("again {row}"), json!({}), vec![steps])
    };
    let transfer = vec![
        leaf("Pick", "pick", json!({ "object": "cube" })),
        leaf(
            "Place",
            "place",
            json!({ "object": "cube", "place": "mark" }),
        ),
    ];
    let transfer = node("Sequence", "transfer", json!({}), transfer);
    let mut children = vec![node(
        "Repeat",
        "job",
        json!({ "count": 30 }),
        vec![transfer],
    )];
    children.extend((0..100).map(row));
    let ends = json!({ "policy": "selected", "selected": ["job"], "synchronise": false });
    json!({
        "format": "behavior-tree/1",
        "name": "large",
        "root": node("Parallel", "all", ends, children),
    })
}

#[test]
#[ignore = "slow: .ci/long"]
fn an_arm_is_jogged_by_keys_and_buttons() {
    browse("jog", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn an_object_is_gripped_by_hand_and_every_outcome_is_said() {
    browse("grasp", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn three_bins_are_stacked_by_hand_with_what_the_page_shows_alone() {
    // By its seed the second bin opens upward, and the next two downward.
    browse("hands", &["ur10-bin-stack", "--seed", "9"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_bin_set_down_by_hand_is_counted() {
    // By its seed the first bin opens downward.
    browse("manual", &["ur10-bin-stack", "--paused", "--seed", "0"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_bin_palletized_by_hand_is_counted() {
    // By its seed the first bin opens upward.
    browse("pallet", &["ur10-palletize", "--paused", "--seed", "1"]);
}

#[test]
fn a_bin_left_on_the_flipping_station_by_hand_is_stacked_and_counted() {
    if !all_of_them() {
        eprintln!("skipped: long; ROBOCELL_PAGE=all runs it");
        return;
    }
    browse("flip", &["ur10-bin-stack", "--paused", "--seed", "1"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_buttons_of_the_bins_do_what_their_commands_do() {
    for demo in ["ur10-palletize", "ur10-fill-bin", "ur10-bin-stack"] {
        browse("bins", &[demo]);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_cube_pulled_by_the_mouse_moves_in_physics_and_the_task_recovers() {
    browse("drag", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_gizmo_leads_the_arm_while_the_task_is_paused() {
    browse("gizmo", &["franka-stack", "--paused"]);
}

#[test]
fn every_button_does_what_its_command_does() {
    browse("buttons", &["franka-stack"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn plots_show_the_past_and_what_was_missed_meanwhile() {
    browse("plots", &["franka-stack"]);
}

#[test]
fn every_crash_is_told_with_its_reason_and_nothing_told_is_lost() {
    browse("crashes", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_page_fits_every_window() {
    browse("windows", &["franka-stack"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_job_is_watched_and_steered_without_a_mouse() {
    browse("keyboard", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_tree_is_an_outline_that_the_keyboard_collapses_and_searches() {
    browse("outline", &["franka-stack", "--policy", "bt"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_drawing_of_a_tree_pans_zooms_and_collapses_and_keeps_its_look() {
    browse("drawing", &["franka-stack", "--policy", "bt"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn guards_of_an_earlier_state_are_dim_with_their_age() {
    browse("guards", &["ur10-bin-stack"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_breakpoint_pauses_the_cell_and_the_task_runs_decision_by_decision() {
    browse(
        "breakpoints",
        &["franka-stack", "--policy", "bt", "--paused"],
    );
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_state_and_a_guard_are_breakpoints_by_the_mouse() {
    browse("breakspots", &["ur10-fill-bin"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_policy_is_edited_checked_and_applied_on_the_page() {
    browse("policy", &["franka-pyramid"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn an_edited_policy_is_saved_to_the_folder_of_data() {
    let data = base();
    let cells = data.path().join("cells");
    fs::create_dir_all(&cells).expect("a folder");
    let built_in = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../cells"));
    for name in ["franka-pyramid.toml", "franka-pyramid.tree.json"] {
        fs::copy(built_in.join(name), cells.join(name)).expect("a copy");
    }
    let folder = data.path().display().to_string();
    browse("saved", &["franka-pyramid", "--data", &folder]);
    if browser().is_ok() {
        let file = cells.join("franka-pyramid.tree.json");
        let text = fs::read_to_string(file).expect("the file");
        assert!(text.contains("\"my-pyramid\""), "the file is what it was");
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_policy_of_code_cannot_be_edited_and_the_page_says_so() {
    browse("code", &["franka-stack"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_page_goes_back_to_what_just_happened() {
    browse("scrub", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn who_may_only_look_is_refused_until_he_presents_the_operators_token() {
    look_at("viewer", || {
        let cell = TestCell::start(&["franka-stack", "--paused"]);
        cell.wait_up();
        let secrets = fs::read_to_string(cell.run_dir().join("page.json")).expect("secrets");
        let secrets: Value = serde_json::from_str(&secrets).expect("JSON");
        let token = |role: &str| secrets[role].as_str().expect("a token").to_owned();
        let link = cell.link();
        let link = link.replace(&token("operator_token"), &token("viewer_token"));
        (cell, link)
    });
}

#[test]
#[ignore = "slow: .ci/long"]
fn lanes_tell_what_lasted_and_the_past_is_played() {
    browse("lanes", &["franka-stack", "--paused", "--speed", "max"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_moment_that_is_looked_at_outlives_its_run() {
    // Slowly: between two runs are 5 s of simulated time, and a loaded machine shows them late.
    browse("earlier", &["cube", "--loop", "--speed", "0.4"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_running_task_that_lost_its_object_is_told() {
    browse("told", &["cube", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_speed_of_a_running_cell_is_changed() {
    browse("speed", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_events_are_filtered() {
    browse("filter", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_recording_is_shown_at_another_speed() {
    look_at("replaySpeed", || {
        let base = base();
        let file = base.path().join("run.mcap").display().to_string();
        let arguments = ["run", "franka-stack", "--headless", "--speed", "max"];
        let arguments = [&arguments[..], &["--timeout", "8", "--record", &file]].concat();
        assert_eq!(finish(robocell(base.path(), &arguments)).code, 5);
        let shown = TestCell::launch(base, &["replay", &file], |_| {});
        let link = shown.link();
        (shown, link)
    });
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_card_tells_where_an_object_is_what_holds_it_and_what_it_touches() {
    browse("inspector", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_slider_moves_its_joint_while_the_task_is_paused() {
    browse("joints", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_labels_of_an_axis_differ() {
    browse("ticks", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn bins_and_parts_that_are_asked_for_are_answered() {
    for demo in ["ur10-palletize", "ur10-fill-bin"] {
        browse("answers", &[demo]);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_drawing_of_a_job_has_what_is_placed_and_in_flight() {
    for demo in ["ur10-palletize", "ur10-bin-stack"] {
        browse("jobDrawing", &[demo, "--speed", "max", "--paused"]);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_load_of_the_cup_is_shown_up_to_the_break_and_of_the_past() {
    browse("load", &["ur10-fill-bin", "--speed", "max"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn what_can_be_pressed_is_large_enough() {
    for demo in ["franka-stack", "ur10-bin-stack"] {
        browse("targets", &[demo, "--paused"]);
    }
}

/// Cell files with such names are refused; a recording can come from anybody.
#[test]
#[ignore = "slow: .ci/long"]
fn names_like_tags_are_text() {
    look_at("names", || {
        let base = base();
        let [file, other] = ["run.mcap", "other.mcap"].map(|name| base.path().join(name));
        let name = file.display().to_string();
        let arguments = ["run", "franka-stack", "--headless", "--speed", "max"];
        let arguments = [&arguments[..], &["--timeout", "2", "--record", &name]].concat();
        assert_eq!(finish(robocell(base.path(), &arguments)).code, 5);
        let rename = |scene: &mut Value| {
            scene["objects"][0]["name"] = json!("<script>owned=1</script>");
            scene["objects"][1]["name"] = json!("<img src=x onerror=owned=1>");
            scene["arms"][0]["name"] = json!("\"><svg onload=owned=1>");
            scene["description"] = json!("</title><script>owned=1</script>");
        };
        rewrite(&file, &other, rename, |_| {});
        let name = other.display().to_string();
        let shown = TestCell::launch(base, &["replay", &name], |_| {});
        let link = shown.link();
        (shown, link)
    });
}

#[test]
fn fetched_meshes_are_loaded_and_drawn() {
    let said = finish(robocell(base().path(), &["assets", "list"]));
    if said.code != 0 {
        eprintln!("skipped: no meshes are here; `robocell assets fetch` fetches them");
        return;
    }
    browse("meshes", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_bar_above_the_view_says_what_the_cell_does_why_it_failed_and_that_it_ended() {
    browse("status", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_recording_shows_its_incidents_lanes_and_faults() {
    look_at("recorded", || {
        let base = base();
        let file = killed_twice(base.path());
        let shown = TestCell::launch(base, &["replay", &file.display().to_string()], |_| {});
        let link = shown.link();
        (shown, link)
    });
}

#[test]
#[ignore = "slow: .ci/long"]
fn every_level_of_quality_has_the_same_tones_and_no_false_shadow() {
    for demo in DEMOS.iter().chain(&["reach-shelf", "cube"]) {
        browse("levels", &[demo, "--paused"]);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_phone_shows_the_state_chooses_a_time_and_pulls_an_object_by_touch() {
    browse("phone", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_task_can_be_read_terms_are_explained_and_the_timeline_zooms() {
    browse("readable", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_guide_is_closed_for_good_comes_back_on_demand_and_is_in_no_picture() {
    browse("guide", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn an_address_names_a_view_and_a_moment() {
    browse("views", &["franka-stack"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_cell_at_rest_is_drawn_once_at_full_resolution() {
    browse("sharp", &["franka-stack", "--paused"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn the_panel_of_reach_leads_the_arm_and_says_what_came_of_it() {
    browse("reach", &["reach"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn each_scene_has_its_own_card_and_panel_and_nothing_of_the_one_before() {
    browse("scenes", &["franka-stack", "--paused"]);
}
