//! Cameras of a cell: `[cameras.NAME]`, and `front`, the view of `[camera]`.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::arm::ArmSpec;
use crate::cells::file::{CameraTable, CellFile};
use crate::check::Checker;
use crate::error::ModelError;
use crate::suggest;

/// Name of the camera with the view of the page.
const FRONT: &str = "front";
/// Name of the frame of the tool centre point in `link`, for all robots.
const TCP: &str = "tcp";
/// Vertical field of view where the file gives none (degrees): that of the page.
const FIELD_OF_VIEW_DEG: f64 = 38.0;
/// Width and height where the file gives none (pixels).
const SIZE: [u32; 2] = [224, 224];
/// Largest width and height of a picture (pixels).
pub const MAX_PIXELS: u32 = 4096;
/// Largest number of cameras of a cell file.
const MAX_CAMERAS: usize = 16;
/// Directions with a smaller sine of the angle between them are parallel.
const LEAST_SINE: f64 = 1.0e-3;

/// A camera of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSpec {
    /// Name in the cell.
    pub name: String,
    /// The frame that carries it; `None` for the world.
    pub mount: Option<CameraMount>,
    /// Pose in that frame (m): x to the right of the picture, y down, z ahead.
    pub pose: Isometry3<f64>,
    /// Vertical field of view (rad), 0 to pi.
    pub field_of_view: f64,
    /// Width of its pictures (pixels).
    pub width: u32,
    /// Height of its pictures (pixels).
    pub height: u32,
}

/// A frame of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CameraMount {
    /// Index of the arm.
    pub arm: usize,
    /// Index of the frame in the chain of its robot.
    pub frame: usize,
}

/// The cameras of a cell file, `front` first, then in the order of their names.
pub(super) fn cameras(
    file: &str,
    text: &str,
    cell: &CellFile,
    arms: &[ArmSpec],
) -> Result<Vec<CameraSpec>, ModelError> {
    let checker = Checker::new(file, text);
    if cell.cameras.len() > MAX_CAMERAS {
        let (value, allowed) = (
            format!("{} entries", cell.cameras.len()),
            format!("0 to {MAX_CAMERAS} are allowed"),
        );
        return Err(checker.refuse("cameras", value, allowed));
    }
    let mut all = Vec::new();
    // A file may give the view of the page another size: then its own table counts.
    if !cell.cameras.contains_key(FRONT)
        && let Some(pose) = looking(cell.camera.eye_m, cell.camera.target_m, Vector3::z())
    {
        all.push(spec(FRONT, None, pose, FIELD_OF_VIEW_DEG, SIZE));
    }
    for (name, table) in &cell.cameras {
        all.push(camera(&checker, name, table, arms)?);
    }
    Ok(all)
}

fn spec(
    name: &str,
    mount: Option<CameraMount>,
    pose: Isometry3<f64>,
    degrees: f64,
    size: [u32; 2],
) -> CameraSpec {
    let (name, field_of_view) = (name.to_owned(), degrees.to_radians());
    let [width, height] = size;
    CameraSpec {
        name,
        mount,
        pose,
        field_of_view,
        width,
        height,
    }
}

fn camera(
    checker: &Checker<'_>,
    name: &str,
    table: &CameraTable,
    arms: &[ArmSpec],
) -> Result<CameraSpec, ModelError> {
    let key = format!("cameras.{name}");
    checker.name(&key, name)?;
    checker.position(&format!("{key}.eye_m"), &table.eye_m)?;
    let degrees = table.fov_deg.unwrap_or(FIELD_OF_VIEW_DEG);
    checker.number(&format!("{key}.fov_deg"), degrees, 1.0, 170.0)?;
    let size = table.size.unwrap_or(SIZE);
    let sides = size.map(f64::from);
    checker.numbers(&format!("{key}.size"), &sides, 1.0, f64::from(MAX_PIXELS))?;
    let pose = pose(checker, &key, table)?;
    let mount = table
        .link
        .as_deref()
        .map(|link| mount(checker, &key, link, arms))
        .transpose()?;
    Ok(spec(name, mount, pose, degrees, size))
}

/// The pose in the frame of the mount, from a target or from a rotation.
fn pose(
    checker: &Checker<'_>,
    key: &str,
    table: &CameraTable,
) -> Result<Isometry3<f64>, ModelError> {
    match (table.target_m, table.rotation_wxyz) {
        (Some(target_m), None) => {
            checker.position(&format!("{key}.target_m"), &target_m)?;
            let up = table.up.unwrap_or([0.0, 0.0, 1.0]);
            checker.numbers(&format!("{key}.up"), &up, -1.0e3, 1.0e3)?;
            looking(table.eye_m, target_m, up.into()).ok_or_else(|| {
                let value = format!("eye_m {:?}, target_m {target_m:?}, up {up:?}", table.eye_m);
                checker.refuse(
                    key,
                    value,
                    "a target away from the eye and an up that is not along the view are needed",
                )
            })
        }
        (None, Some([w, x, y, z])) => {
            if table.up.is_some() {
                return Err(checker.refuse(
                    &format!("{key}.up"),
                    "a direction",
                    "it is for target_m; rotation_wxyz says all",
                ));
            }
            let rotation = nalgebra::Quaternion::new(w, x, y, z);
            // Numbers of three digits are within these bounds.
            checker.number(
                &format!("{key}.rotation_wxyz"),
                rotation.norm(),
                0.999,
                1.001,
            )?;
            let rotation = UnitQuaternion::new_normalize(rotation);
            Ok(Isometry3::from_parts(
                Translation3::from(Vector3::from(table.eye_m)),
                rotation,
            ))
        }
        (given, _) => {
            let value = if given.is_some() { "both" } else { "neither" };
            Err(checker.refuse(key, value, "one of target_m and rotation_wxyz is needed"))
        }
    }
}

/// Pose of a camera (m) at `eye` that looks at `target`, with `up` in the upper half of its picture:
/// x to the right of the picture, y down, z ahead. `None` where eye and target are one, or `up` is
/// along the view.
pub fn looking(eye: [f64; 3], target: [f64; 3], up: Vector3<f64>) -> Option<Isometry3<f64>> {
    let eye = Vector3::from(eye);
    let ahead = (Vector3::from(target) - eye).try_normalize(1.0e-6)?;
    let right = ahead
        .cross(&up.try_normalize(1.0e-6)?)
        .try_normalize(LEAST_SINE)?;
    let axes = Matrix3::from_columns(&[right, ahead.cross(&right), ahead]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Some(Isometry3::from_parts(Translation3::from(eye), rotation))
}

/// The frame that `ARM/FRAME` names.
fn mount(
    checker: &Checker<'_>,
    key: &str,
    link: &str,
    arms: &[ArmSpec],
) -> Result<CameraMount, ModelError> {
    let refuse = |name: &str, known: &[&str]| {
        let allowed = format!(
            "ARM/LINK is needed, or ARM/{TCP}; {}",
            suggest::advice(name, known)
        );
        Err(checker.refuse(&format!("{key}.link"), format!("'{link}'"), allowed))
    };
    let (arm_name, frame_name) = link.split_once('/').unwrap_or((link, ""));
    let Some(arm) = arms.iter().position(|arm| arm.name == arm_name) else {
        let names: Vec<&str> = arms.iter().map(|arm| arm.name.as_str()).collect();
        return refuse(arm_name, &names);
    };
    let robot = &arms[arm].robot;
    // Before the frames of the robot, one of which may have this name, too.
    if frame_name == TCP {
        return Ok(CameraMount {
            arm,
            frame: robot.tcp_frame,
        });
    }
    let Some(frame) = robot.chain.frame_index(frame_name) else {
        let frames = robot.chain.frames();
        let names: Vec<&str> = frames.iter().map(|frame| frame.name.as_str()).collect();
        return refuse(frame_name, &names);
    };
    Ok(CameraMount { arm, frame })
}
