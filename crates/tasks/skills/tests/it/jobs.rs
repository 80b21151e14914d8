//! Machines and matrices in files, decision by decision: the results of steps, events, and what
//! a reset and a restart keep.

use std::path::PathBuf;

use cell_model::{Cell, Data};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmStatus, Decision, Header, Wire as _, WorldState};
use robocell_skills::with_file_jobs;
use robocell_task::{Policies, Task};

/// A job in a file, in a cell with a cube and a mark. Its folder is removed with it.
struct FileJob {
    folder: PathBuf,
    cell: Cell,
    task: Task,
    state: Box<WorldState>,
    decision: Box<Decision>,
}

impl Drop for FileJob {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.folder).ok();
    }
}

impl FileJob {
    fn new(test: &str, kind: &str, text: &str) -> Self {
        let name = format!("robocell-job-{test}-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(folder.join("cells")).unwrap();
        let cell = Data::checkout().read("cells/cube.toml").unwrap();
        let head = format!("kind = \"{kind}\"\nbehaviour = \"job.toml\"");
        let cell = cell.replace("kind = \"cube\"", &head);
        std::fs::write(folder.join("cells/mine.toml"), cell).unwrap();
        std::fs::write(folder.join("cells/job.toml"), text).unwrap();
        let data = Data::dir(folder.clone()).with_robots_of(&Data::checkout());
        let cell = Cell::load(&data, "mine", 0, None).unwrap();
        let mut state = Box::new(WorldState::zeroed());
        (state.arm_count, state.object_count) = (1, 1);
        state.arms[0].tcp.position = [0.4, 0.0, 0.4];
        state.arms[0].tcp.orientation_wxyz = [0.0, 1.0, 0.0, 0.0];
        state.arms[0].gripper.width = 0.08;
        state.objects[0].flags = OBJECT_ENABLED;
        state.objects[0].pose.position = [0.5, -0.25, 0.025];
        state.objects[0].pose.orientation_wxyz = [1.0, 0.0, 0.0, 0.0];
        Self {
            folder,
            task: task(&cell),
            cell,
            state,
            decision: Box::new(Decision::zeroed()),
        }
    }

    fn decide(&mut self) {
        let tick = self.state.header.tick + 10;
        self.state.header = Header::caused_by::<WorldState>(tick);
        let none: [Option<&ArmStatus>; 1] = [None];
        self.task
            .decide(&self.state, &none, &mut self.decision, &mut Vec::new());
    }

    /// Decides `count` times; the phase then.
    fn after(&mut self, count: u32) -> &str {
        (0..count).for_each(|_| self.decide());
        self.decision.phase.as_str()
    }

    /// Another process continues from the checkpoint.
    fn restart(&mut self) {
        let record = self.task.checkpoint();
        self.task = task(&self.cell);
        self.task.restore(&record).unwrap();
    }

    fn outcome(&self) -> Outcome {
        Outcome::from_code(self.decision.outcome).unwrap()
    }

    /// The cube is between the fingers, or it is on the table.
    fn hold(&mut self, holds: bool) {
        let arm = &mut self.state.arms[0];
        arm.gripper.held_object = u32::from(holds);
        arm.gripper.width = if holds { 0.05 } else { 0.08 };
        self.state.objects[0].pose.position = if holds {
            arm.tcp.position
        } else {
            [0.5, -0.25, 0.025]
        };
    }
}

fn task(cell: &Cell) -> Task {
    let policies = with_file_jobs(Policies::new());
    match policies.task(cell, cell.task.kind()) {
        Ok(task) => task,
        Err(error) => panic!("{error}"),
    }
}

/// A machine that waits until the cube is held for 0.1 s; `more` is a part of its state.
fn waits(more: &str, rest: &str) -> String {
    format!(
        r#"
version = 1
name = "job"
initial = "wait"
[[states]]
name = "wait"
during.success = "over"
{more}
during.steps = [{{ do = "Holding", object = "cube" }}, {{ do = "Stay", for_s = 0.1 }}]
[[states]]
name = "done"
final = true
[[rows]]
trigger = "over"
source = "wait"
dest = "done"
{rest}
"#
    )
}

#[test]
fn steps_that_fail_start_again_where_no_trigger_is_named_for_it() {
    let mut job = FileJob::new("again", "machine", &waits("", ""));
    assert_eq!(job.after(20), "wait");
    assert_eq!(job.outcome(), Outcome::Running);
    job.hold(true);
    assert_eq!(job.after(5), "wait", "the second step");
    assert_eq!(job.after(7), "done");
    assert_eq!(job.outcome(), Outcome::Done);
}

#[test]
fn steps_that_fail_fire_their_trigger_and_a_state_gives_the_job_up_with_its_reason() {
    let lost = r#"
[[states]]
name = "lost"
during.steps = [{ do = "FailJob", reason = "no_cube" }]
[[rows]]
trigger = "missing"
source = "wait"
dest = "lost"
"#;
    let text = waits("during.failure = \"missing\"", lost);
    let mut job = FileJob::new("fires", "machine", &text);
    job.after(3);
    assert_eq!(job.outcome(), Outcome::Failed);
    assert_eq!(job.decision.reason.as_str(), "no_cube");
    assert_eq!(job.decision.goals[0].kind, GoalKind::Hold.code());
}

/// A machine whose events are conditions of several parts.
const EVENTS: &str = r#"
version = 1
name = "job"
initial = "wait"
[[states]]
name = "wait"
during.steps = [{ do = "Stay", for_s = 100.0 }]
[[states]]
name = "busy"
during.steps = [{ do = "Stay", for_s = 100.0 }]
[events]
ready = { do = "Sequence", children = [{ do = "Started" }, { do = "GripperOpen" }] }
taken = { do = "Holding", object = "cube" }
[[rows]]
trigger = "ready"
source = "wait"
dest = "busy"
[[rows]]
trigger = "taken"
source = "busy"
dest = "wait"
"#;

#[test]
fn an_event_of_several_conditions_waits_for_all_of_them() {
    let mut job = FileJob::new("events", "machine", EVENTS);
    job.hold(true);
    job.state.panel.task_start = 1;
    assert_eq!(job.after(5), "wait", "the start event was not given before");
    job.state.panel.task_start = 2;
    assert_eq!(job.after(5), "wait", "the gripper is not open");
    job.hold(false);
    assert_eq!(job.after(1), "busy");
    job.hold(true);
    assert_eq!(job.after(1), "wait");
}

#[test]
fn a_reset_of_the_task_starts_a_machine_in_its_first_state_with_all_its_events() {
    let mut job = FileJob::new("reset", "machine", EVENTS);
    job.state.panel.task_started = 1;
    assert_eq!(job.after(2), "busy");
    job.state.panel.task_reset = 1;
    job.state.panel.task_started = 0;
    assert_eq!(job.after(3), "wait");
    job.state.panel.task_start = 1;
    job.state.panel.task_started = 1;
    assert_eq!(job.after(2), "busy", "the event fires in the new job, too");
}

/// A matrix that waits above the cube, and goes up where it is held.
const MATRIX: &str = r#"
version = 1
name = "job"
states = ["WORK", { name = "DONE", final = true }]
initial = "WORK"
precedence = ["OVER", "HELD", "LOST"]
[events]
HELD = { do = "Holding", object = "cube" }
LOST = { do = "Holding", object = "cube", not = true }
[cells.WORK]
OVER = { handler = "rest", goto = "DONE" }
HELD = "wait"
LOST = "go"
[cells.DONE]
LOST = "rest"
[handlers.go]
steps = [{ do = "MoveTo", pose = [0.5, 0.1, 0.3] }]
[handlers.wait]
success = "OVER"
steps = [{ do = "Stay", for_s = 0.3 }]
[handlers.rest]
steps = [{ do = "Stay", for_s = 1.0 }]
"#;

#[test]
fn another_handler_stops_the_steps_of_the_one_before_and_starts_its_own_anew() {
    let mut job = FileJob::new("handlers", "matrix", MATRIX);
    job.after(5);
    let goal = job.decision.goals[0];
    assert_eq!(goal.target.position, [0.5, 0.1, 0.3]);
    for _ in 0..3 {
        // 0.2 s of the stay, three times: each time it starts from its beginning.
        job.hold(true);
        assert_eq!(job.after(20), "WORK");
        job.hold(false);
        assert_eq!(job.after(5), "WORK");
    }
    assert!(job.decision.goals[0].goal_id > goal.goal_id, "a new motion");
    job.hold(true);
    assert_eq!(job.after(33), "DONE");
    assert_eq!(job.outcome(), Outcome::Done);
}

#[test]
fn nobody_notices_a_restart_before_each_decision() {
    for (kind, text) in [("machine", waits("", "")), ("matrix", MATRIX.to_owned())] {
        let run = |restarts: bool| {
            let test = format!("restart-{kind}-{restarts}");
            let mut job = FileJob::new(&test, kind, &text);
            let mut phases = Vec::new();
            for decision in 0..80 {
                job.hold((10..25).contains(&decision) || decision > 30);
                if restarts {
                    job.restart();
                }
                job.decide();
                phases.push((job.decision.phase, job.decision.goals[0].goal_id));
            }
            assert_eq!(job.outcome(), Outcome::Done, "{kind}");
            phases
        };
        assert_eq!(run(true), run(false), "{kind}");
    }
}

/// [`EVENTS`] and [`MATRIX`] with an event whose condition is asked 0.3 s late.
fn delayed(test: &str, kind: &str) -> FileJob {
    let modifiers = "modifiers = [{ type = \"Delay\", ports = { seconds = 0.3 } }]";
    let holding = "{ do = \"Holding\", object = \"cube\" }";
    let delayed = holding.replace(" }", &format!(", {modifiers} }}"));
    let goes = "HELD = { handler = \"wait\", goto = \"DONE\" }";
    let text = if kind == "machine" { EVENTS } else { MATRIX };
    let text = text
        .replace(holding, &delayed)
        .replace("HELD = \"wait\"", goes);
    assert!(text.contains("Delay"));
    let mut job = FileJob::new(&format!("{test}-{kind}"), kind, &text);
    job.state.panel.task_started = 1;
    job.after(2);
    job
}

/// Decisions until the event has fired and changed the phase.
fn until_fired(job: &mut FileJob, restarts: bool) -> u32 {
    let phase = job.decision.phase;
    job.hold(true);
    for count in 1..=100 {
        if restarts {
            job.restart();
        }
        job.decide();
        if job.decision.phase != phase {
            return count;
        }
    }
    panic!("the event did not fire")
}

#[test]
fn a_condition_with_a_delay_fires_in_time_though_its_task_is_killed() {
    for kind in ["machine", "matrix"] {
        for restarts in [false, true] {
            let fired = until_fired(&mut delayed("killed", kind), restarts);
            // A machine asks from the second decision on, a matrix from the first.
            let expected = if kind == "machine" { 30 } else { 29 };
            assert_eq!(fired, expected, "{kind}, restarts: {restarts}");
        }
    }
}

#[test]
fn a_condition_with_a_delay_starts_again_with_the_job() {
    for kind in ["machine", "matrix"] {
        let mut job = delayed("anew", kind);
        job.hold(true);
        job.after(25);
        job.state.panel.task_reset += 1;
        // The decision with the reset is the first one of the new job.
        job.after(1);
        if kind == "machine" {
            job.hold(false);
            assert_eq!(job.after(1), "busy");
        }
        let expected = if kind == "machine" { 31 } else { 30 };
        assert_eq!(until_fired(&mut job, false), expected, "{kind}");
    }
}
