//! What cameras of a cell see, by their names.

use cell_model::cells::cell::CameraSpec;
use cell_model::{Cell, suggest};
use ipc_types::WorldState;

use crate::{Light, Picture, Scene, View, draw};

/// A name that no camera of the cell has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("camera '{name}' is not known; {advice}")]
pub struct UnknownCamera {
    name: String,
    advice: String,
}

/// Pictures of the cameras of these names, in their order.
///
/// # Errors
/// For a name that no camera of the cell has.
pub fn observe(
    cell: &Cell,
    state: &WorldState,
    names: &[String],
) -> Result<Vec<Picture>, UnknownCamera> {
    let known = |name: &String| {
        let found = cell.cameras.iter().find(|camera| camera.name == *name);
        let names: Vec<&str> = cell.cameras.iter().map(|c| c.name.as_str()).collect();
        found.ok_or_else(|| UnknownCamera {
            name: name.clone(),
            advice: suggest::advice(name, &names),
        })
    };
    let cameras: Vec<&CameraSpec> = names.iter().map(known).collect::<Result<_, _>>()?;
    let scene = Scene::new(cell, state);
    let light = Light::of(&cell.light);
    let pictures = cameras
        .into_iter()
        .map(|camera| draw(&scene, &View::of(cell, state, camera), &light));
    Ok(pictures.collect())
}
