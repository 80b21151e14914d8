//! The stacking tasks as they are: a decision, and the checkpoint after it.

use std::error::Error;
use std::hint::black_box;

use cell_model::{Cell, Data};
use cell_sim::{OneProcess, eval};
use ipc_types::{ArmStatus, Decision, Wire, WorldState};
use robocell_task::{Task, TraceLineText};

use super::subject::Subject;

const DEMO: &str = "franka-stack";
/// Ticks before the state used for the decision: on the way to the first cube.
const TICKS: u32 = 300;

/// A decision of each policy upon a state that stays the same, and its checkpoint.
pub(crate) fn subjects() -> Result<Vec<Subject>, Box<dyn Error>> {
    let scene = Situation::new()?;
    Ok(vec![
        scene.decision("franka-stack bt: decision", "bt")?,
        scene.decision("franka-stack fsm: decision", "fsm")?,
        scene.checkpoint("franka-stack bt: checkpoint", "bt")?,
        scene.checkpoint("franka-stack fsm: checkpoint", "fsm")?,
    ])
}

struct Situation {
    cell: Cell,
    state: Box<WorldState>,
    status: ArmStatus,
}

/// A task after its first decision.
struct Begun {
    task: Task,
    state: Box<WorldState>,
    status: ArmStatus,
    decision: Decision,
    trace: Vec<TraceLineText>,
}

impl Begun {
    fn decide(&mut self) {
        self.trace.clear();
        let status = [Some(&self.status)];
        self.task
            .decide(&self.state, &status, &mut self.decision, &mut self.trace);
    }
}

impl Situation {
    fn new() -> Result<Self, Box<dyn Error>> {
        let spec = eval::template(DEMO, "fsm");
        let cell = spec.load_cell_from(&Data::checkout())?;
        let mut sim = OneProcess::new(&demos::policies(), &spec, cell.clone())?;
        for _ in 0..TICKS {
            sim.tick()?;
        }
        Ok(Self {
            cell,
            state: Box::new(*sim.state()),
            status: *sim.statuses().first().ok_or("the cell has no arm")?,
        })
    }

    fn begun(&self, policy: &str) -> Result<Begun, Box<dyn Error>> {
        let mut begun = Begun {
            task: demos::policies().task(&self.cell, policy)?,
            state: self.state.clone(),
            status: self.status,
            decision: Decision::zeroed(),
            trace: Vec::with_capacity(robocell_task::output::ROOM_FOR_LINES),
        };
        // The first decision sets the task up and is not measured.
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

    fn checkpoint(&self, name: &'static str, policy: &str) -> Result<Subject, Box<dyn Error>> {
        let begun = self.begun(policy)?;
        Ok(Subject::new(name, move |times| {
            for _ in 0..times {
                black_box(begun.task.checkpoint());
            }
        }))
    }
}
