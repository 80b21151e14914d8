//! The stacking tasks as they are: a decision, and the checkpoint after it.

use std::error::Error;
use std::hint::black_box;

use cell_model::Cell;
use cell_sim::{OneProcess, eval, run};
use ipc_types::{ArmStatus, Decision, Wire, WorldState};
use task_proc::Task;

use crate::subject::Subject;

const DEMO: &str = "franka-stack";
/// Ticks before the state that is decided upon: on the way to the first cube.
const TICKS: u32 = 300;

/// A decision of each policy upon a state that stays the same, and its record.
pub(crate) fn subjects() -> Result<Vec<Subject>, Box<dyn Error>> {
    let scene = Scene::new()?;
    Ok(vec![
        scene.decision("franka-stack bt: decision", "bt")?,
        scene.decision("franka-stack fsm: decision", "fsm")?,
        scene.record("franka-stack bt: record", "bt")?,
        scene.record("franka-stack fsm: record", "fsm")?,
    ])
}

struct Scene {
    cell: Cell,
    state: Box<WorldState>,
    status: ArmStatus,
}

/// A task that has begun.
struct Begun {
    task: Task,
    state: Box<WorldState>,
    status: ArmStatus,
    decision: Decision,
    trace: Vec<task_proc::TraceLineText>,
}

impl Begun {
    fn decide(&mut self) {
        self.trace.clear();
        let status = [Some(&self.status)];
        self.task
            .decide(&self.state, &status, &mut self.decision, &mut self.trace);
    }
}

impl Scene {
    fn new() -> Result<Self, Box<dyn Error>> {
        let spec = eval::template(DEMO, "fsm");
        let mut sim = OneProcess::new(&spec, run::cell_of(&spec)?)?;
        for _ in 0..TICKS {
            sim.tick()?;
        }
        Ok(Self {
            cell: run::cell_of(&spec)?,
            state: Box::new(*sim.state()),
            status: *sim.statuses().first().ok_or("the cell has no arm")?,
        })
    }

    fn begun(&self, policy: &str) -> Result<Begun, Box<dyn Error>> {
        let mut begun = Begun {
            task: Task::new(&self.cell, policy)?,
            state: self.state.clone(),
            status: self.status,
            decision: Decision::zeroed(),
            trace: Vec::with_capacity(task_proc::output::ROOM_FOR_LINES),
        };
        begun.decide();
        Ok(begun)
    }

    fn decision(&self, name: &'static str, policy: &str) -> Result<Subject, Box<dyn Error>> {
        let mut begun = self.begun(policy)?;
        Ok(Subject::new(name, move |times| {
            for _ in 0..times {
                begun.decide();
                black_box(&begun.decision);
            }
        }))
    }

    fn record(&self, name: &'static str, policy: &str) -> Result<Subject, Box<dyn Error>> {
        let begun = self.begun(policy)?;
        Ok(Subject::new(name, move |times| {
            for _ in 0..times {
                black_box(begun.task.record());
            }
        }))
    }
}
