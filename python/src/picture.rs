//! Pictures of a cell as arrays: by the cameras of its file, and from any point.

use camera::{Light, Picture, Scene, View, draw};
use cell_model::Cell;
use cell_model::cells::cell::{MAX_PIXELS, looking};
use ipc_types::WorldState;
use nalgebra::Vector3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

/// Vertical field of view of a picture from any point (rad): that of `front`.
const FIELD_OF_VIEW: f64 = 38.0 / 180.0 * std::f64::consts::PI;

/// Colour (height x width x 3), depth (m) and mask of a camera.
pub(crate) type Seen<'py> = (
    Bound<'py, PyArray3<u8>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<u16>>,
);

/// A picture from `eye_m` towards `target_m`, by default those of the first view of the page.
///
/// # Errors
/// For a size that is not allowed, and where the points give no direction.
pub(crate) fn from_point(
    cell: &Cell,
    state: &WorldState,
    (width, height): (u32, u32),
    (eye_m, target_m): (Option<[f64; 3]>, Option<[f64; 3]>),
) -> Result<Picture, String> {
    if !(1..=MAX_PIXELS).contains(&width) || !(1..=MAX_PIXELS).contains(&height) {
        return Err(format!(
            "a picture of {width} x {height} pixels; 1 to {MAX_PIXELS} are allowed in each direction"
        ));
    }
    let (eye, target) = (
        eye_m.unwrap_or(cell.camera.eye_m),
        target_m.unwrap_or(cell.camera.target_m),
    );
    let is_finite = eye.iter().chain(&target).all(|x| x.is_finite());
    // Straight up and down the picture has x to the right.
    let pose = looking(eye, target, Vector3::z()).or_else(|| looking(eye, target, Vector3::y()));
    let pose = pose
        .filter(|_| is_finite)
        .ok_or_else(|| format!("no direction of view: eye {eye:?} m, target {target:?} m"))?;
    let view = View::new(pose, FIELD_OF_VIEW, width, height);
    Ok(draw(&Scene::new(cell, state), &view, &Light::default()))
}

/// Colour as an array.
pub(crate) fn colour<'py>(
    py: Python<'py>,
    picture: &Picture,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let [height, width] = [picture.height, picture.width].map(|count| count as usize);
    PyArray1::from_slice(py, &picture.rgb).reshape([height, width, 3])
}

/// All of a picture as arrays.
pub(crate) fn arrays<'py>(py: Python<'py>, picture: &Picture) -> PyResult<Seen<'py>> {
    let size = [picture.height, picture.width].map(|count| count as usize);
    Ok((
        colour(py, picture)?,
        PyArray1::from_slice(py, &picture.depth_m).reshape(size)?,
        PyArray1::from_slice(py, &picture.mask).reshape(size)?,
    ))
}
