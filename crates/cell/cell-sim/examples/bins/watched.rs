//! A run that is looked after tick by tick.

use cell_model::TaskTable;
use cell_sim::{OneProcess, eval::template};
use ipc_types::decision::Outcome;
use ipc_types::operator::OperatorAction;
use ipc_types::{ObjectState, OperatorRequest};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::touches::Touches;

/// A run and what was seen of it.
pub(crate) struct Watched {
    /// The cell.
    pub(crate) sim: OneProcess,
    /// Settings of its task.
    pub(crate) task: TaskTable,
    /// Bins the job is about.
    pub(crate) bins: usize,
    /// Contacts of the arm.
    pub(crate) touches: Touches,
    loud: bool,
}

impl Watched {
    /// The task is started at once.
    pub(crate) fn new(demo: &str, policy: &str, seed: u64) -> Self {
        let mut spec = template(demo, policy);
        spec.seed = seed;
        spec.until_done = false;
        let cell = spec
            .load_cell_from(&cell_model::Data::checkout())
            .expect("the built-in cell");
        spec.time_limit_s = Some(cell.time_limit_s);
        let (bins, task) = (cell.bins, cell.task.clone());
        let touches = Touches::new(&cell);
        let mut sim = OneProcess::new(&demos::policies(), &spec, cell).expect("a cell that runs");
        sim.answer_request(&OperatorRequest {
            action: OperatorAction::TaskStart.code(),
            ..OperatorRequest::zeroed_at_identity()
        });
        Self {
            sim,
            task,
            bins,
            touches,
            loud: std::env::var_os("LINES").is_some(),
        }
    }

    /// One tick; the log lines of it go to `on_line`. `false` at the end.
    pub(crate) fn tick(&mut self, mut on_line: impl FnMut(&str)) -> bool {
        let goes_on = self.sim.tick().expect("a tick");
        for (tick, line) in self.sim.take_trace() {
            on_line(&line);
            if self.loud {
                println!("{:9.3} {line}", tick as f64 * 1.0e-3);
            }
        }
        self.touches.look(&self.sim, self.loud);
        goes_on
    }

    /// Outcome of the task.
    pub(crate) fn outcome(&self) -> Option<Outcome> {
        Outcome::from_code(self.sim.decision().outcome)
    }

    /// Simulated time (s).
    pub(crate) fn now_s(&self) -> f64 {
        self.sim.state().header.tick as f64 * 1.0e-3
    }

    /// Commands beyond a limit.
    pub(crate) fn violations(&self) -> u64 {
        let arms = self.sim.state().arms().iter();
        arms.map(|arm| arm.limit_violations).sum()
    }
}

/// Height of an object's own z axis: 1 upright, -1 upside down.
pub(crate) fn up(object: &ObjectState) -> f64 {
    let [w, x, y, z] = object.pose.orientation_wxyz;
    (UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)) * Vector3::z()).z
}
