//! Reads meshes: STL, OBJ and COLLADA.

use std::path::Path;

use crate::collada;
use cell_model::user_file;
use nalgebra::Point3;

use crate::spheres::surface::Surface;

/// Largest file that is read: meshes are drawn with some tens of megabytes at most.
const MAX_BYTES: u64 = 256 << 20;
/// Largest coordinate (in the unit of the file).
const MAX_COORDINATE: f64 = 1e7;

/// Reads a mesh, in the unit of the file, metres for COLLADA.
pub(crate) fn read(path: &Path) -> Result<Surface, String> {
    let bytes = user_file::read(path, MAX_BYTES).map_err(|error| error.to_string())?;
    let end = path.extension().and_then(|end| end.to_str()).unwrap_or("");
    let surface = match end.to_ascii_lowercase().as_str() {
        "stl" => of_scene(&mesh_loader::stl::from_slice(&unambiguous(bytes))),
        "obj" => {
            // Its materials have no shape.
            let nothing = |_: &Path| Ok(Vec::new());
            of_scene(&mesh_loader::obj::from_slice(&bytes, None, nothing))
        }
        "dae" => of_collada(path, &String::from_utf8_lossy(&bytes)),
        other => Err(format!(
            "files that end in '{other}' are not read; STL, OBJ and DAE are"
        )),
    }?;
    check(&surface)?;
    Ok(surface)
}

/// Blanks the start of a binary STL, which may be `solid`, the first word of an STL in text. The
/// number of triangles and the length of the file distinguish the two.
fn unambiguous(mut stl: Vec<u8>) -> Vec<u8> {
    let count = stl.get(80..84).and_then(|bytes| bytes.try_into().ok());
    let length = count.map(|count| 84 + 50 * u64::from(u32::from_le_bytes(count)));
    if length == u64::try_from(stl.len()).ok() {
        stl[..5].fill(b' ');
    }
    stl
}

fn of_scene(read: &std::io::Result<mesh_loader::Scene>) -> Result<Surface, String> {
    let scene = read.as_ref().map_err(ToString::to_string)?;
    let mut surface = Surface::default();
    for mesh in &scene.meshes {
        let part = Surface {
            points: mesh
                .vertices
                .iter()
                .map(|p| Point3::from(p.map(f64::from)))
                .collect(),
            triangles: mesh.faces.clone(),
        };
        surface.append(&part);
    }
    Ok(surface)
}

fn of_collada(path: &Path, text: &str) -> Result<Surface, String> {
    let meshes = collada::read_up(&crate::spheres::name_of(path), text, collada::Up::Ignored)
        .map_err(|error| error.to_string())?;
    let mut surface = Surface::default();
    for mesh in meshes {
        let part = Surface {
            points: mesh.positions.into_iter().map(Point3::from).collect(),
            triangles: mesh.triangles,
        };
        surface.append(&part);
    }
    Ok(surface)
}

/// A file may say anything.
fn check(surface: &Surface) -> Result<(), String> {
    if surface.triangles.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    let far = |x: &f64| !x.is_finite() || x.abs() > MAX_COORDINATE;
    if let Some(point) = surface.points.iter().find(|p| p.iter().any(far)) {
        return Err(format!(
            "it has a point at {:?}; finite numbers up to {MAX_COORDINATE} are allowed",
            point.coords.as_slice()
        ));
    }
    let points = surface.points.len();
    // `Surface::corners` indexes with these numbers.
    let corners = surface.triangles.iter().flatten();
    match corners
        .into_iter()
        .find(|&&corner| corner as usize >= points)
    {
        Some(corner) => Err(format!("a triangle names point {corner} of {points}")),
        None => Ok(()),
    }
}
