//! The reason of a failure, for the summary of a run.

use cell_model::{Cell, Data};
use ipc_types::{Decision, Header, Wire as _, WorldState};
use robocell_task::{Job, Observation, Output, Policy, TraceEvent, boxed};

use super::*;

/// Reports a fault with another number in each decision; from `fails` on the job is given up.
struct Faulty {
    fails: u32,
}

impl Policy for Faulty {
    type Memory = u32;

    fn decide(&self, count: &mut u32, _: &Observation<'_>, job: &mut Job, out: &mut Output) {
        *count += 1;
        out.event(TraceEvent::Fault, format_args!("[fault] number {count}"));
        if *count >= self.fails {
            job.fail("too_many_faults");
        }
    }
}

struct Run {
    dir: PathBuf,
    task: Task,
    tick: u64,
}

impl Drop for Run {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.dir).ok();
    }
}

impl Run {
    fn new(test: &str, fails: u32) -> Self {
        let name = format!("robocell-message-{test}-{}", std::process::id());
        let dir = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&dir).unwrap();
        let cell = Cell::load(&Data::checkout(), "reach", 1, None).unwrap();
        let task = Task::new(&cell, "faulty", 0.0, boxed(Faulty { fails }));
        Self { dir, task, tick: 0 }
    }

    /// Decides and tells the file; the sentence that a reader of the directory finds.
    fn decide(&mut self, file: &mut MessageFile) -> Option<String> {
        self.tick += 10;
        let mut state = WorldState::zeroed();
        state.header = Header::caused_by::<WorldState>(self.tick);
        let (mut out, mut lines) = (Decision::zeroed(), Vec::new());
        self.task.decide(&state, &[], &mut out, &mut lines);
        file.decided(&self.task);
        self.read()
    }

    fn read(&self) -> Option<String> {
        Message::load(&self.dir).text().map(str::to_owned)
    }
}

#[test]
fn a_fault_whose_text_changes_is_written_once_a_second_and_the_last_one_at_the_end() {
    let mut run = Run::new("changes", u32::MAX);
    let mut file = MessageFile::open(&run.dir);
    let mut found: Vec<_> = (0..250).map(|_| run.decide(&mut file).unwrap()).collect();
    found.dedup();
    assert_eq!(found, ["number 1", "number 101", "number 201"]);
    file.end();
    assert_eq!(run.read().as_deref(), Some("number 250"));
}

#[test]
fn the_reason_of_a_failure_is_written_at_once_and_kept_by_the_next_process() {
    let mut run = Run::new("fails", 5);
    let mut file = MessageFile::open(&run.dir);
    for _ in 0..4 {
        assert_eq!(run.decide(&mut file).as_deref(), Some("number 1"));
    }
    assert_eq!(run.decide(&mut file).as_deref(), Some("number 5"));
    // A killed process runs no destructor.
    std::mem::forget(file);
    let record = run.task.checkpoint();
    run.task.restore(&record).unwrap();
    let mut file = MessageFile::open(&run.dir);
    assert_eq!(
        run.task.message(),
        None,
        "the sentence is not in the checkpoint"
    );
    assert_eq!(run.decide(&mut file).as_deref(), Some("number 5"));
}
