//! Jobs that are files: several objects, patterns, both grippers, and what ends
//! them with a reason.

use cell_model::Data;
use cell_run::summary::RunSummary;
use cell_sim::{SimError, eval};

/// A folder with a cell and its behaviour; removed with it.
struct Job(std::path::PathBuf);

impl Drop for Job {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

impl Job {
    /// `cells/cube.toml` with these objects, with `[task]` and a behaviour file.
    fn new(name: &str, kind: &str, objects: &[(&str, [f64; 2])], place: &str, text: &str) -> Self {
        let dir = std::env::temp_dir().join(format!("robocell-jobs-{name}-{}", std::process::id()));
        std::fs::create_dir_all(dir.join("cells")).unwrap();
        let cell = Data::checkout().read("cells/cube.toml").unwrap();
        let (head, rest) = cell.split_once("[[object]]").unwrap();
        let (object, rest) = rest.split_once("\n# Not an obstacle").unwrap();
        let (fixtures, _) = rest.split_once("[task]").unwrap();
        let objects = objects.iter().map(|(name, [x, y])| {
            let object = object.replace("\"cube\"", &format!("\"{name}\""));
            format!(
                "[[object]]{}",
                object.replace("0.50, -0.25", &format!("{x:.2}, {y:.2}"))
            )
        });
        let objects: String = objects.collect();
        let head = head.split("policies").next().unwrap().to_owned()
            + &format!("policies = [\"{kind}\"]\ndefault_policy = \"{kind}\"\n")
            + head.split("default_policy = \"ifelse\"\n").nth(1).unwrap();
        let task = format!("[task]\nkind = \"{kind}\"\nbehaviour = \"job.{kind}\"\n{place}\n");
        let cell = format!("{head}{objects}\n# Not an obstacle{fixtures}{task}")
            .replace("x_m = 0.03, y_m = 0.05", "x_m = 0.01, y_m = 0.01");
        std::fs::write(dir.join(format!("cells/{name}.toml")), cell).unwrap();
        let file = format!("cells/job.{kind}");
        std::fs::write(dir.join(file), text).unwrap();
        Self(dir)
    }

    fn run(&self, name: &str, kind: &str, script: &str) -> RunSummary {
        self.try_run(name, kind, script).unwrap()
    }

    fn try_run(&self, name: &str, kind: &str, script: &str) -> Result<RunSummary, SimError> {
        let mut spec = eval::template(name, kind);
        spec.data_dir = Some(self.0.clone());
        spec.seed = 2;
        spec.script = cell_model::cells::script::parse(script, "script").unwrap();
        cell_sim::run::to_the_end(&crate::program(), &spec, |_| {})
    }

    /// The same cell with a second arm, which takes no part in the job.
    fn with_idle_arm(self, name: &str, base: &str) -> Self {
        let path = self.0.join(format!("cells/{name}.toml"));
        let text = std::fs::read_to_string(&path).unwrap();
        let (_, arm) = text.split_once("[[arm]]\n").unwrap();
        let (arm, _) = arm.split_once("\n\n").unwrap();
        let idle = arm
            .replace("\"panda\"\nrobot", "\"idle\"\nrobot")
            .replace("[0.0, 0.0, 0.0]", base);
        let both = format!("{arm}\n\n[[arm]]\n{idle}");
        std::fs::write(&path, text.replacen(arm, &both, 1)).unwrap();
        self
    }

    /// The same cell with a UR10 in place of the Panda.
    fn with_suction(self, name: &str) -> Self {
        let path = self.0.join(format!("cells/{name}.toml"));
        let text = std::fs::read_to_string(&path).unwrap();
        let text = text.replace("robot = \"panda\"", "robot = \"ur10\"");
        let text = text.replace(
            "[0.012, -0.5686, 0.0, -2.8102, 0.0, 3.0366, 0.741]",
            "[-1.57, -1.57, -1.57, -1.57, 1.57, 0.0]",
        );
        std::fs::write(path, text).unwrap();
        self
    }
}

const TOWER: &str = r#"
[task.place.tower]
position_m = [0.50, 0.25, 0.0]
pattern = { kind = "stack", layers = 3, layer_height_m = 0.05 }
"#;
const CUBES: [(&str, [f64; 2]); 3] = [
    ("red", [0.55, -0.35]),
    ("green", [0.55, -0.2]),
    ("blue", [0.42, -0.28]),
];

/// One cube after the other: it is on the tower, or it is brought there. Then the
/// tower is full, or all starts again. It is the recipe of docs/task-in-a-file.md.
fn tower() -> String {
    let one = |name: &str| {
        format!(
            r#"{{"id": "{name}", "type": "Selector", "children": [
                {{"id": "{name}_at", "type": "At", "ports": {{"object": "{name}", "place": "tower"}}}},
                {{"id": "{name}_bring", "type": "Sequence", "children": [
                    {{"id": "{name}_pick", "type": "Pick", "ports": {{"object": "{name}"}}}},
                    {{"id": "{name}_place", "type": "Place",
                      "ports": {{"object": "{name}", "place": "tower"}}}}]}}]}}"#
        )
    };
    let all: Vec<String> = CUBES.iter().map(|(name, _)| one(name)).collect();
    format!(
        r#"{{"format": "behavior-tree/1", "name": "tower", "root":
            {{"id": "job", "type": "Sequence",
              "children": [{},
                {{"id": "full", "type": "Full", "ports": {{"place": "tower"}}}},
                {{"id": "home", "type": "Home"}}]}}}}"#,
        all.join(",")
    )
}

#[test]
fn a_tower_is_built_with_fingers_and_with_suction_and_again_when_it_is_disturbed() {
    let pull = r#"{"at_s": 10.5, "do": "drag", "object": "red", "to": [0.35, -0.05, 0.025]}"#;
    let panda = Job::new("tower", "tree", &CUBES, TOWER, &tower());
    let disturbed = panda.run("tower", "tree", pull);
    assert_eq!(disturbed.placed.len(), 3, "{disturbed:?}");
    let ur10 = Job::new("suction", "tree", &CUBES, TOWER, &tower()).with_suction("suction");
    let calm = ur10.run("suction", "tree", "");
    assert_eq!(calm.placed.len(), 3, "{calm:?}");
    assert_eq!((calm.drops, calm.limit_violations), (0, 0), "{calm:?}");
}

/// [`tower`] with its three selectors as one.
const TOWER_OF_EACH: &str = r#"{"format": "behavior-tree/1", "name": "tower", "root":
    {"id": "job", "type": "Sequence", "children": [
        {"id": "cubes", "type": "ForEach", "as": "cube", "items": ["red", "green", "blue"],
         "children": [{"id": "cube", "type": "Selector", "children": [
            {"id": "at", "type": "At", "ports": {"object": "${cube}", "place": "tower"}},
            {"id": "bring", "type": "Sequence", "children": [
                {"id": "pick", "type": "Pick", "ports": {"object": "${cube}"}},
                {"id": "place", "type": "Place",
                 "ports": {"object": "${cube}", "place": "tower"}}]}]}]},
        {"id": "full", "type": "Full", "ports": {"place": "tower"}},
        {"id": "home", "type": "Home"}]}}"#;

#[test]
fn a_loop_over_the_cubes_does_what_the_copies_do_killed_or_not() {
    let each = Job::new("each", "tree", &CUBES, TOWER, TOWER_OF_EACH);
    let copies = Job::new("copies", "tree", &CUBES, TOWER, &tower());
    let pull = |phase: &str, then: &str| {
        format!("{{\"at_phase\": \"{phase}\", \"after_s\": 0.2, {then}}}\n")
    };
    let drag = "\"do\": \"drag\", \"object\": \"blue\", \"to\": [0.35, -0.05, 0.025]";
    let wanted = copies.run("copies", "tree", &pull("green_pick", drag));
    assert_eq!(wanted.placed.len(), 3, "{wanted:?}");
    let kill = "\"do\": \"kill\", \"process\": \"task\"";
    for phase in ["pick[green]", "PANDA_PICK_GREEN"] {
        let killed = pull(phase, drag) + &pull("PLACE_GREEN", kill) + &pull("pick[blue]", kill);
        let done = each.run("each", "tree", &killed);
        assert_eq!(done.state_hash, wanted.state_hash, "{phase}: {done:?}");
        assert_eq!((done.script_left, done.task_restarts), (0, 2), "{done:?}");
    }
}

/// A machine of one state with these steps.
fn one_state(steps: &str) -> String {
    format!(
        "version = 1\nname = \"job\"\ninitial = \"work\"\n\
         [[states]]\nname = \"work\"\nduring.success = \"over\"\nduring.steps = [{steps}]\n\
         [[states]]\nname = \"done\"\nfinal = true\n\
         [[rows]]\ntrigger = \"over\"\nsource = \"work\"\ndest = \"done\"\n"
    )
}

/// The end of a job of one state with these steps.
fn reason(name: &str, steps: &str, place: &str) -> Option<String> {
    let job = Job::new(name, "machine", &CUBES, place, &one_state(steps));
    job.run(name, "machine", "").reason
}

#[test]
fn what_cannot_be_done_ends_with_its_reason() {
    let place = "{ do = \"Place\", object = \"red\", place = \"tower\" }";
    let both = format!("{{ do = \"Pick\", object = \"red\" }}, {place}");
    // It was not picked.
    let reason_of = |name, steps: &str, place: &str| reason(name, steps, place);
    assert_eq!(
        reason_of("unpicked", place, TOWER).as_deref(),
        Some("object_not_in_gripper")
    );
    let far = TOWER.replace("0.50, 0.25", "2.50, 0.25");
    let refused = Job::new("far", "machine", &CUBES, &far, &one_state(&both));
    let refused = refused.try_run("far", "machine", "").unwrap_err();
    assert!(
        refused.to_string().contains("no arm reaches it"),
        "{refused}"
    );
    // Another arm than that of the job reaches it.
    let idle = Job::new("idle", "machine", &CUBES, &far, &one_state(&both))
        .with_idle_arm("idle", "[2.0, 0.0, 0.0]");
    assert_eq!(
        idle.run("idle", "machine", "").reason.as_deref(),
        Some("place_out_of_reach")
    );
    let taken = TOWER.replace("0.50, 0.25", "0.55, -0.17");
    assert_eq!(
        reason_of("taken", &both, &taken).as_deref(),
        Some("blocked_by_object")
    );
    // The first one is brought back.
    let two = "{ do = \"Pick\", object = \"red\" }, { do = \"Pick\", object = \"blue\" }";
    assert_eq!(reason_of("two", two, TOWER), None);
}

#[test]
fn an_event_without_a_cell_does_not_keep_the_one_behind_it_from_being_handled() {
    let text = r#"
version = 1
name = "job"
states = ["WORK", { name = "DONE", final = true }]
initial = "WORK"
precedence = ["FIRST", "SECOND"]
[events]
FIRST = { do = "GripperOpen" }
SECOND = { do = "Reachable", object = "red" }
[cells.WORK]
SECOND = { handler = "end", goto = "DONE" }
[cells.DONE]
FIRST = "end"
[handlers.end]
steps = [{ do = "Stay", for_s = 0.1 }]
"#;
    let job = Job::new("events", "matrix", &CUBES, TOWER, text);
    let summary = job.run("events", "matrix", "");
    assert!(summary.sim_time_s < 1.0, "{summary:?}");
}

/// The condition of the event is true all the time: without memory of it the state that it
/// leads to was entered again in every decision, and its work never ended.
#[test]
fn an_event_that_stays_true_enters_a_state_once_killed_or_not() {
    let text = r#"
version = 1
name = "job"
initial = "work"
[[states]]
name = "work"
during.steps = [{ do = "Stay", for_s = 0.3 }]
[[states]]
name = "aside"
during.success = "over"
during.steps = [{ do = "Stay", for_s = 0.3 }]
[[states]]
name = "done"
final = true
[events]
nothing = { do = "Holding", object = "red", not = true }
[[rows]]
trigger = "nothing"
source = "*"
dest = "aside"
[[rows]]
trigger = "over"
source = "aside"
dest = "done"
"#;
    let job = Job::new("level", "machine", &CUBES, TOWER, text);
    for text in [
        text.to_owned(),
        text.replace("\"*\"", "[\"work\", \"aside\"]"),
    ] {
        std::fs::write(job.0.join("cells/job.machine"), text).unwrap();
        let calm = job.run("level", "machine", "");
        assert!(calm.sim_time_s < 0.4, "{calm:?}");
        let kill = r#"{"at_s": 0.15, "do": "kill", "process": "task"}"#;
        let killed = job.run("level", "machine", kill);
        assert_eq!(calm.state_hash, killed.state_hash, "{killed:?}");
    }
}

const BRING: &str = r#"
version = 1
name = "bring"
initial = "fetch"
[[states]]
name = "fetch"
during.success = "over"
during.steps = [{ do = "Pick", object = "red" }]
[[states]]
name = "put"
during.success = "over"
during.steps = [{ do = "Place", object = "red", place = "tower" }]
[[states]]
name = "there"
final = true
[[rows]]
trigger = "over"
source = "fetch"
dest = "put"
[[rows]]
trigger = "over"
source = "put"
dest = "there"
"#;

/// A tree that runs the machine `file`, and then moves the arm home.
fn tree_with(file: &str) -> String {
    format!(
        r#"{{"format": "behavior-tree/1", "name": "tower", "root":
            {{"id": "job", "type": "Sequence", "ports": {{"memory": true}}, "children": [
                {{"id": "bring", "type": "RunMachine", "ports": {{"file": "{file}"}}}},
                {{"id": "home", "type": "Home"}}]}}}}"#
    )
}

#[test]
fn a_leaf_of_a_tree_runs_a_machine_killed_or_not() {
    let job = Job::new(
        "nested",
        "tree",
        &CUBES,
        TOWER,
        &tree_with("bring.machine.toml"),
    );
    std::fs::write(job.0.join("cells/bring.machine.toml"), BRING).unwrap();
    let run = |restarts: bool| {
        let mut spec = eval::template("nested", "tree");
        spec.data_dir = Some(job.0.clone());
        let cell = spec.load_cell_from(&Data::checkout()).unwrap();
        let mut sim = cell_sim::OneProcess::new(&demos::policies(), &spec, cell).unwrap();
        let mut lines = Vec::new();
        while sim.tick().unwrap() {
            lines.extend(sim.take_trace().into_iter().map(|(_, line)| line));
            // No whole number of decisions, so that every step meets it.
            if restarts && sim.state().header.tick.is_multiple_of(197) {
                sim.restart_task().unwrap();
            }
        }
        assert_eq!(sim.decision().placed_count, 1, "{lines:#?}");
        let entered = lines
            .iter()
            .filter(|line| line.starts_with("  -> "))
            .count();
        assert_eq!(entered, 2, "put, there: {lines:#?}");
        sim.state().state_hash
    };
    assert_eq!(run(false), run(true));
}

#[test]
fn machines_that_run_each_other_are_refused() {
    let job = Job::new(
        "circle",
        "tree",
        &CUBES,
        TOWER,
        &tree_with("a.machine.toml"),
    );
    let to = |file: &str| {
        BRING.replace(
            "do = \"Pick\", object = \"red\"",
            &format!("do = \"RunMachine\", file = \"{file}\""),
        )
    };
    std::fs::write(job.0.join("cells/a.machine.toml"), to("b.machine.toml")).unwrap();
    std::fs::write(job.0.join("cells/b.machine.toml"), to("a.machine.toml")).unwrap();
    let mut spec = eval::template("circle", "tree");
    spec.data_dir = Some(job.0.clone());
    let refused = cell_sim::run::to_the_end(&crate::program(), &spec, |_| {});
    let error = refused.unwrap_err().to_string();
    let circle = "a.machine.toml -> b.machine.toml -> a.machine.toml";
    assert!(error.contains(circle), "{error}");
}
