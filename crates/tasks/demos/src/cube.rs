//! One small job as six policies: three in Rust and three in files, side by side in
//! `cells/cube/`.

#[path = "../../../../cells/cube/fsm.rs"]
mod fsm;
#[path = "../../../../cells/cube/ifelse.rs"]
mod ifelse;
#[path = "../../../../cells/cube/tree.rs"]
mod tree;

use std::sync::Arc;

use cell_model::Cell;
use robocell_skills::files::{self, TreeSource};
use robocell_skills::setup::ARM;
use robocell_skills::{Places, Setup};
use robocell_task::{Goals, Kind, SetupError, Slots, boxed};

/// A cube nearer to the mark in the plane, and in height, is on it (m).
const TOLERANCE_M: f64 = 0.02;
const HEIGHT_TOLERANCE_M: f64 = 0.01;

/// `kind = "cube"` and its policies.
pub fn kind() -> Kind<Places> {
    Kind::<Places>::new("cube")
        .goals(goals)
        .policy("ifelse", |task, cell| {
            let (setup, cube, mark) = parts(task, cell)?;
            Ok(boxed(ifelse::IfElse { setup, cube, mark }))
        })
        .policy("fsm", |task, cell| {
            let (setup, cube, mark) = parts(task, cell)?;
            Ok(boxed(fsm::Fsm { setup, cube, mark }))
        })
        .policy("tree", |task, cell| {
            let (setup, cube, mark) = parts(task, cell)?;
            let tree = tree::tree(cube, mark);
            let tree = tree.map_err(|error| SetupError::new(cell, error.to_string()))?;
            Ok(files::tree_in_code(&setup, tree))
        })
        .policy("json", |task, cell| {
            let source = TreeSource {
                file: "cube/cube.tree.json".to_owned(),
                board: "shared".to_owned(),
            };
            files::tree(cell, &task.place, &[source])
        })
        .policy("table", |task, cell| {
            files::machine(cell, &task.place, "cube/cube.machine.toml")
        })
        .policy("matrix", |task, cell| {
            files::matrix(cell, &task.place, "cube/cube.matrix.toml")
        })
}

/// The cube on the mark.
fn goals(task: &Places, cell: &Cell) -> Result<Goals, SetupError> {
    let (setup, cube, mark) = parts(task, cell)?;
    let place = setup.places.get(mark).and_then(|place| place.slots.first());
    let half_height_m = setup
        .objects
        .get(cube)
        .map_or(0.0, |cube| cube.half_height_m);
    let centre = place.map(|slot| {
        let [x, y, z] = slot.position;
        [x, y, z + half_height_m]
    });
    Ok(Goals(vec![Slots {
        centres: centre.into_iter().collect(),
        objects: Some(vec![cube]),
        tolerance_m: [TOLERANCE_M, HEIGHT_TOLERANCE_M],
    }]))
}

/// The setup and the two objects that the policies in Rust need.
fn parts(task: &Places, cell: &Cell) -> Result<(Arc<Setup>, usize, usize), SetupError> {
    let setup = Setup::new(cell, &task.place);
    let cube = setup.need_object(cell, "cube")?;
    let mark = setup.need_place(cell, "mark")?;
    // Checked while the task is loaded: an arm that cannot grip the cube would fail only when
    // it gets there.
    setup.need_grip(cell, ARM, cube)?;
    Ok((Arc::new(setup), cube, mark))
}
