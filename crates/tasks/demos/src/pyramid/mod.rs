//! Two arms take a pyramid of cubes apart, each with a behaviour tree from a file: one file, an
//! instance for each arm.
//!
//! The trees share a blackboard. A cube is reserved by one arm at a time, and the centre, where
//! the pyramid is, is owned by one arm at a time. The state of a stack on the blackboard is
//! compared with the observation whenever it matters, so no cube is counted twice and none is
//! lost without notice.
//!
//! Motions, grips, zones, reservations and the policy are those of `robocell_skills`; this
//! module chooses the next cube and its place.

mod look;
mod nodes;
mod notes;
pub mod numbers;
mod setup;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::Arc;

use behavior::Value;
use behavior::tree::Library;
use cell_model::{Cell, Data};
use robocell_skills::Station;
use robocell_skills::files::{TreeJob, TreePolicy, TreeSource};
use robocell_skills::nodes::{WorkKeys, library as skills, with_work};
use robocell_task::{Goals, Kind, SetupError, Slots};

pub use setup::Pyramid;

use crate::stack::{HEIGHT_TOLERANCE_M, layers};
use look::Look;
use numbers::PyramidTask;

/// The demo whose cubes and arms the names in a tree file refer to.
const DEMO: &str = "franka-pyramid";

/// Names on the blackboards of the trees.
const KEYS: WorkKeys = WorkKeys {
    object: "current_cube",
    reference: "pickup_reference",
    owners: "cube_state",
    zone: "center",
};

/// A stack of any cubes for each arm.
fn goals(task: &PyramidTask, cell: &Cell) -> Goals {
    let count = task.required_count as usize;
    let heights_m = (task.base_height_m, task.layer_height_m);
    let slots = |goal_m| Slots {
        centres: layers(goal_m, heights_m, count),
        objects: None,
        tolerance_m: [task.goal_tolerance_m, HEIGHT_TOLERANCE_M],
    };
    let arms = cell.arms.iter().filter_map(|arm| task.robot.get(&arm.name));
    Goals(arms.map(|arm| slots(arm.goal_m)).collect())
}

/// `kind = "pyramid"` and its policy.
pub fn kind() -> Kind<PyramidTask> {
    Kind::<PyramidTask>::new("pyramid")
        .goals(|task, cell| Ok(goals(task, cell)))
        .policy("json", |task, cell| Ok(Box::new(policy(task, cell)?)))
        .trees(|data: &Data| {
            let cell = Cell::load(data, DEMO, 0, None)?;
            let task: PyramidTask = cell.task.read()?;
            Ok(library(&Arc::new(Pyramid::new(&task, &cell)?)))
        })
}

/// The trees of `cell`, read from the files it names.
///
/// # Errors
/// Returns a [`SetupError`] for a cell that cannot make a pyramid, and one with all errors of a
/// file.
pub fn policy(task: &PyramidTask, cell: &Cell) -> Result<TreePolicy, SetupError> {
    let pyramid = Arc::new(Pyramid::new(task, cell)?);
    let mut job = TreeJob::new(Arc::clone(&pyramid.setup));
    job.library = library(&pyramid);
    let required = Value::Integer(i64::from(task.required_count));
    job.constants = BTreeMap::from([("required_count".to_owned(), required)]);
    // Once: both trees end with their stack, and would start again with an empty one otherwise.
    job.once = true;
    let seen = Arc::clone(&pyramid);
    job.is_still_done = Some(Box::new(move |world| {
        let look = Look { job: &seen, world };
        look.is_whole() && !look.helps()
    }));
    job.tolerance_m = task.goal_tolerance_m;
    let arms = cell.arms.iter().filter_map(|arm| task.robot.get(&arm.name));
    let sources = arms.map(|arm| TreeSource {
        file: arm.behaviour.clone(),
        board: arm.board.clone(),
    });
    job.policy(cell, &sources.collect::<Vec<_>>())
}

/// The skills and the node types of this demo. Each type is also known by its name in older
/// files.
fn library(job: &Arc<Pyramid>) -> Library<Station> {
    let skills = with_work(skills(&job.setup), &job.setup, KEYS);
    nodes::add(skills, job)
}
